from dataclasses import replace

import cv2
import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, pixels_of, random_pose

from shirube_core.geometry import SE2, SE3, LensModel, gravity_aligned_camera
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import NoBeaconFix, NoFixReason
from vlc_beacon.core.pose.radius_interval import LampDiscs, radius_interval, radius_interval_printed

LEVEL = gravity_aligned_camera(MOUNT)
DEPTH = 2.5
TRUE_RADIUS = 0.0325 * 636.4 / DEPTH


def discs(pose, noise=0.0, step=0.0, rng=None):
    pixels = pixels_of(BEACONS, pose)
    radii = np.full(4, TRUE_RADIUS)
    if rng is not None:
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        radii = np.round((radii + 0.1 * rng.normal(size=4)) / step) * step
    return LampDiscs(BEACONS, pixels, radii)


def test_exact_sizes_give_the_exact_pose():
    rng = np.random.default_rng(1)
    for _ in range(20):
        pose = random_pose(rng)
        fix = radius_interval(discs(pose), CAMERA, LEVEL, pose.yaw)
        assert fix.T_map_base.distance_to(pose) < 1e-9
        assert fix.height == pytest.approx(0.0, abs=1e-9)


def test_counted_radii_give_the_centimetres_of_the_paper():
    rng = np.random.default_rng(2)
    errors = []
    for _ in range(200):
        pose = random_pose(rng)
        fix = radius_interval(discs(pose, 0.2, 0.5, rng), CAMERA, LEVEL, pose.yaw)
        if not isinstance(fix, NoBeaconFix):
            errors.append(fix.T_map_base.distance_to(pose))
    assert len(errors) > 150
    assert 0.0005 < np.median(errors) < 0.02


def imaged_disc(beacon, pose, camera):
    """Return centroid and radius of equal area of a lamp in an image with distortion, from 2000 projected points."""
    angles = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    x, y, z = beacon.xyz
    rim = [Beacon(1, (x + 0.0325 * c, y + 0.0325 * s, z), 0.0) for c, s in zip(np.cos(angles), np.sin(angles))]
    moments = cv2.moments(pixels_of(rim, pose, camera=camera).astype(np.float32)[:, None])
    area = moments['m00']
    return (moments['m10'] / area, moments['m01'] / area), np.sqrt(area / np.pi)


@pytest.mark.parametrize(
    'camera',
    [
        replace(CAMERA, distortion=(-0.25, 0.08, 0.001, -0.002, 0.0)),
        replace(CAMERA, distortion=(-0.012, 0.021, -0.018, 0.004), model=LensModel.EQUIDISTANT),
    ],
)
def test_a_distorting_lens_gives_the_same_pose(camera):
    rng = np.random.default_rng(3)
    errors = []
    for _ in range(50):
        pose = random_pose(rng)
        pixels, radii = zip(*(imaged_disc(beacon, pose, camera) for beacon in BEACONS), strict=True)
        fix = radius_interval(LampDiscs(BEACONS, np.array(pixels), np.array(radii)), camera, LEVEL, pose.yaw)
        errors.append(fix.T_map_base.distance_to(pose))
        assert fix.height == pytest.approx(0.0, abs=0.002)
    assert max(errors) < 0.002


def test_disjoint_intervals_and_no_lamps_are_no_fix():
    seen, empty = discs(SE2(0.9, 0.9, 0.2)), LampDiscs([], np.empty((0, 2)), np.empty(0))
    seen.radii[1] *= 1.3
    assert radius_interval(seen, CAMERA, LEVEL, 0.2).reason is NoFixReason.INCONSISTENT
    for method in (radius_interval, radius_interval_printed):
        assert method(empty, CAMERA, LEVEL, 0.0).reason is NoFixReason.NO_LAMP


def test_the_printed_equations_are_far_off():
    # The plus of eq. (5) puts the camera over the ceiling; the focal length of eq. (2) moves it to the wrong side.
    pose = SE2(0.9, 0.9, 0.0)
    fix = radius_interval_printed(discs(pose), CAMERA, LEVEL, 0.0)
    assert fix.height == pytest.approx(2.0 * DEPTH)
    lone = LampDiscs(BEACONS[3:], pixels_of(BEACONS[3:], pose), np.array([TRUE_RADIUS]))
    camera = np.array([pose.x, pose.y]) + LEVEL.position[:2]
    way = np.array(BEACONS[3].xyz[:2]) - camera
    fix = radius_interval_printed(lone, CAMERA, LEVEL, 0.0)
    printed = np.array([fix.T_map_base.x, fix.T_map_base.y]) + LEVEL.position[:2]
    assert printed - BEACONS[3].xyz[:2] == pytest.approx(0.5 * way, abs=0.01)


def test_the_fix_is_the_middle_of_the_intersection_and_its_covariance_that_of_the_interval():
    """Equations (3) to (7) again, lamp by lamp and axis by axis, without noise of the centres."""
    pose, level = SE2(0.4, 1.1, 0.0), SE3(np.eye(3), np.zeros(3))
    camera = np.array([pose.x, pose.y, 0.3])
    rays = [(np.array(beacon.xyz) - camera) / (beacon.xyz[2] - camera[2]) for beacon in BEACONS]
    radii = TRUE_RADIUS + np.array([0.2, -0.15, 0.05, 0.1])
    pixels = np.array([636.4 * ray[:2] + (639.5, 511.5) for ray in rays])
    fix = radius_interval(LampDiscs(BEACONS, pixels, radii, 0.0), CAMERA, level, 0.0)
    middles, widths = [], []
    for axis in range(3):
        lows, highs = [], []
        for beacon, ray, radius in zip(BEACONS, rays, radii, strict=True):
            depth, near, far = (0.0325 * 636.4 / (radius + off) for off in (0.0, 0.25, -0.25))
            middle, half = beacon.xyz[axis] - depth * ray[axis], 0.5 * (far - near) * abs(ray[axis])
            lows.append(middle - half)
            highs.append(middle + half)
        middles.append((max(lows) + min(highs)) / 2.0)
        widths.append(min(highs) - max(lows))
    assert (fix.T_map_base.x, fix.T_map_base.y, fix.height) == pytest.approx(middles)
    # A uniform distribution of width w has the variance w^2 / 12.
    assert np.diag(fix.covariance)[:3] == pytest.approx(np.array(widths) ** 2 / 12.0)


@pytest.mark.parametrize(('turned', 'focal_scale', 'error'), [(False, 2.0, 1.5), (True, 2.0, 0.5), (True, 1.0, 0.0)])
def test_with_half_a_turn_and_the_factor_of_eq_2_the_printed_equations_are_right_in_the_plane(
    turned, focal_scale, error
):
    lamp, level = BEACONS[:1], SE3(np.diag([-1.0, -1.0, 1.0]) if turned else np.eye(3), np.zeros(3))
    pixel = np.array([[636.4 * 0.3 + 640.0, 636.4 * 0.2 + 512.0]])
    fix = radius_interval_printed(LampDiscs(lamp, pixel, np.array([TRUE_RADIUS])), CAMERA, level, 0.0, focal_scale)
    truth = np.array(lamp[0].xyz[:2]) - DEPTH * np.array([0.3, 0.2])
    found = np.array([fix.T_map_base.x, fix.T_map_base.y])
    assert np.linalg.norm(found - truth) == pytest.approx(error * DEPTH * np.hypot(0.3, 0.2), abs=1e-9)
    # Eq. (6) as printed is the full width of both directions.
    half_width = 0.0325 * 636.4 * (1.0 / (TRUE_RADIUS - 0.25) - 1.0 / (TRUE_RADIUS + 0.25))
    assert fix.covariance[0, 0] == pytest.approx(half_width**2 / 3.0)
