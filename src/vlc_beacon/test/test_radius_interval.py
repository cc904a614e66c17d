import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, pixels_of, random_pose

from shirube_core.geometry import SE2, gravity_aligned_camera
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


def test_disjoint_intervals_and_no_lamps_are_no_fix():
    seen, empty = discs(SE2(0.9, 0.9, 0.2)), LampDiscs([], np.empty((0, 2)), np.empty(0))
    seen.radii[1] *= 1.3
    assert radius_interval(seen, CAMERA, LEVEL, 0.2).reason is NoFixReason.INCONSISTENT
    for method in (radius_interval, radius_interval_printed):
        assert method(empty, CAMERA, LEVEL, 0.0).reason is NoFixReason.NO_LAMP


def test_the_printed_equations_are_far_off():
    # The plus of eq. (5) puts the camera over the ceiling; with the focal length of eq. (2) a lamp that is u aside
    # moves the camera by half the way, to the wrong side.
    pose = SE2(0.9, 0.9, 0.0)
    fix = radius_interval_printed(discs(pose), CAMERA, LEVEL, 0.0)
    assert fix.height == pytest.approx(2.0 * DEPTH)
    lone = LampDiscs(BEACONS[3:], pixels_of(BEACONS[3:], pose), np.array([TRUE_RADIUS]))
    camera = np.array([pose.x, pose.y]) + LEVEL.position[:2]
    way = np.array(BEACONS[3].xyz[:2]) - camera
    fix = radius_interval_printed(lone, CAMERA, LEVEL, 0.0)
    printed = np.array([fix.T_map_base.x, fix.T_map_base.y]) + LEVEL.position[:2]
    assert printed - BEACONS[3].xyz[:2] == pytest.approx(0.5 * way, abs=0.01)
