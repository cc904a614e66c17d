import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, UNEVEN, normalised_square, pixels_of, random_pose

from shirube_core.geometry import SE2, LensModel, PinholeCamera
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon, row_motions
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconFix, ExpectedPose, NoBeaconFix, NoFixReason
from vlc_beacon.core.settings import PoseSettings

MOVED, SWAPPED, DUPLICATED = AnomalyKind.MOVED, AnomalyKind.SWAPPED, AnomalyKind.DUPLICATED
EXACT = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.0)
NEARLY = np.diag([0.05**2, 0.05**2, 0.05**2])
LEVEL = (0.0, 0.0)


def locate(beacons, seen, pose, rng=None, *, noise=0.0, tilt=LEVEL, told=LEVEL, expected=None, **options):
    """Locate a robot by beacons as they really hang, with the ids that they play; it is told a part of its tilt."""
    locator = BeaconLocator(beacons, MOUNT, **{'settings': EXACT, **options})
    pixels = pixels_of(seen, pose, tilt=tilt) if seen else np.empty((0, 2))
    if noise:
        pixels = pixels + noise * rng.normal(size=pixels.shape)
    rays = locator.rays(CAMERA, [b.id for b in seen], pixels, np.full(len(seen), noise or 0.05))
    return locator.locate(rays, told, expected)


def moved(beacon, **coordinates):
    """Return a beacon that hangs elsewhere."""
    return replace(beacon, xyz=tuple(coordinates.get(k, v) for k, v in zip('xyz', beacon.xyz)))


@pytest.mark.parametrize('beacons', [BEACONS, UNEVEN])
def test_exact_centres_give_the_exact_pose(beacons):
    rng = np.random.default_rng(1)
    for _ in range(20):
        pose, tilt = random_pose(rng), tuple(rng.normal(size=2) * 0.05)
        fix = locate(beacons, beacons, pose, tilt=tilt, told=tilt)
        assert fix.T_map_base.distance_to(pose) < 1e-7
        assert fix.T_map_base.yaw_to(pose) == pytest.approx(0.0, abs=1e-7)
        assert fix.height == pytest.approx(0.0, abs=1e-7)
        assert fix.anomalies == ()


def test_a_fisheye_lens_gives_the_pose_and_the_lamps_beyond_its_range_are_left_out():
    lens = np.array([-0.012, 0.021, -0.018, 0.004])
    camera = PinholeCamera(800, 800, 280.0, 281.0, 402.0, 398.0, tuple(lens), LensModel.EQUIDISTANT)
    pose, distant = SE2(0.9, 0.2, 0.7), Beacon(9, (5.0, -3.0, 2.6), 0.0325)
    lamps = [*UNEVEN, distant]
    there = pixels_of(lamps, pose, camera=PinholeCamera(1, 1, 1.0, 1.0, 0.0, 0.0))  # rays by the pinhole
    points = np.column_stack([there, np.ones(len(lamps))])[:, None]
    pixels, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, lens)
    assert np.hypot(*there[-1]) > 2.2  # 65 degrees off the axis
    outside = [[402.0 + 281.0 * 1.7, 398.0]]
    locator = BeaconLocator([*lamps, Beacon(10, (0.0, 0.0, 2.5), 0.0325)], MOUNT, settings=EXACT)
    ids = [*(lamp.id for lamp in lamps), 10]
    rays = locator.rays(camera, ids, np.vstack([pixels[:, 0], outside]), np.full(len(ids), 0.05))
    assert 10 not in rays.ids
    fix = locator.locate(rays)
    assert len(fix.used) == len(lamps)
    assert fix.T_map_base.distance_to(pose) < 1e-6
    assert fix.T_map_base.yaw_to(pose) == pytest.approx(0.0, abs=1e-6)


def test_the_pose_follows_every_motion_of_the_map():
    rng = np.random.default_rng(2)
    pose, motion = random_pose(rng), SE2(3.0, -2.0, 1.9)
    elsewhere = [replace(b, xyz=(*motion.transform([b.xyz[:2]])[0].tolist(), b.xyz[2] + 0.7)) for b in UNEVEN]
    pixels = pixels_of(UNEVEN, pose) + 0.2 * rng.normal(size=(5, 2))
    rays = BeaconLocator(UNEVEN, MOUNT).rays(CAMERA, [1, 2, 3, 4, 5], pixels, np.full(5, 0.2))
    here, there = (BeaconLocator(lamps, MOUNT).locate(rays) for lamps in (UNEVEN, elsewhere))
    assert there.T_map_base.distance_to(motion @ here.T_map_base) < 1e-6
    assert there.height == pytest.approx(here.height + 0.7, abs=1e-6)


@pytest.mark.parametrize('count', [2, 3, 4])
def test_a_robot_that_looks_backwards_has_one_pose(count):
    rng = np.random.default_rng(8)
    for _ in range(30):
        pose = SE2(*rng.uniform(0.5, 1.3, 2), math.pi)
        fix = locate(UNEVEN, UNEVEN[:count], pose, rng, noise=0.1)
        if count > 2 or isinstance(fix, BeaconFix):
            assert abs(fix.T_map_base.yaw_to(pose)) < 0.02
        fix = locate(BEACONS, BEACONS[:count], pose, rng, noise=0.1)
        assert fix.T_map_base.distance_to(pose) < 0.02


@pytest.mark.parametrize('height', [None, 0.0])
@pytest.mark.parametrize('count', [2, 4])
@pytest.mark.newest_set_only
def test_errors_are_those_of_the_cramer_rao_bound(height, count):
    rng = np.random.default_rng(3)
    normalised = []
    for _ in range(250):
        pose = random_pose(rng)
        fix = locate(BEACONS, BEACONS[:count], pose, rng, noise=0.3, known_height=height)
        error = np.array(
            [fix.T_map_base.x - pose.x, fix.T_map_base.y - pose.y, fix.height, pose.yaw_to(fix.T_map_base)]
        )
        keep = [0, 1, 3] if height == 0.0 else [0, 1, 2, 3]
        square = error[keep] @ np.linalg.solve(fix.covariance[np.ix_(keep, keep)], error[keep])
        normalised.append(square / len(keep))
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.2)


@pytest.mark.newest_set_only
def test_the_covariance_knows_of_tilt():
    rng = np.random.default_rng(4)
    settings = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.005)
    normalised = []
    for _ in range(250):
        pose, tilt = random_pose(rng), 0.005 * rng.normal(size=2)
        fix = locate(BEACONS, BEACONS, pose, rng, noise=0.3, tilt=tilt, settings=settings)
        normalised.append(normalised_square(fix.T_map_base, fix.covariance[:2, :2], pose))
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.2)


def test_tilt_error_matches_the_geometry():
    pose, tilt = SE2(0.9, 0.9, 0.0), (math.radians(0.5), 0.0)
    given = {'tilt': tilt, 'settings': PoseSettings(tilt_sigma=0.0)}
    modelled, unmodelled = (locate(BEACONS, BEACONS, pose, told=told, **given) for told in (tilt, LEVEL))
    assert modelled.T_map_base.distance_to(pose) < 1e-6
    assert unmodelled.T_map_base.distance_to(pose) == pytest.approx(2.8 * math.radians(0.5), rel=0.5)


def test_a_distorting_lens_is_undone():
    camera = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5, (-0.2, 0.05, 0.001, -0.001, 0.0))
    pose = SE2(0.6, 1.1, 0.4)
    locator = BeaconLocator(BEACONS, MOUNT, None, EXACT)
    rays = locator.rays(camera, [1, 2, 3, 4], pixels_of(BEACONS, pose, camera=camera), np.full(4, 0.1))
    assert locator.locate(rays).T_map_base.distance_to(pose) < 1e-6


PAIRS = ((0, 1), (1, 3), (0, 3))


def pushed(lamp):
    """Return beacons of which one hangs 15 cm aside."""
    return [moved(b, x=b.xyz[0] + 0.15 * (i == lamp)) for i, b in enumerate(UNEVEN)]


def swapped(first, second, beacons=UNEVEN):
    """Return beacons of which two hang at each other's places."""
    places = {first: beacons[second].xyz, second: beacons[first].xyz}
    return [replace(b, xyz=places.get(i, b.xyz)) for i, b in enumerate(beacons)]


@pytest.mark.parametrize(
    ('beacons', 'seen', 'anomalies'),
    [
        *((UNEVEN, pushed(i), {(i + 1, MOVED, None)}) for i in range(5)),
        *((UNEVEN, swapped(i, j), {(i + 1, SWAPPED, j + 1), (j + 1, SWAPPED, i + 1)}) for i, j in PAIRS),
        (BEACONS, [*BEACONS, Beacon(3, (0.4, 0.6, 2.8), 0.0325)], {(3, DUPLICATED, None)}),
    ],
)
def test_moved_swapped_and_duplicated_lamps_are_named(beacons, seen, anomalies):
    rng = np.random.default_rng(5)
    pose = random_pose(rng)
    fix = locate(beacons, seen, pose, rng, noise=0.2)
    assert fix.T_map_base.distance_to(pose) < 0.02
    assert {(d.id, d.kind, d.swapped_with) for d in fix.anomalies} == anomalies
    assert len(fix.anomalies) == len(anomalies)
    assert all(d.observation == 4 for d in fix.anomalies if d.kind is DUPLICATED)


@pytest.mark.parametrize(
    ('seen', 'reason', 'ids', 'spread', 'anomalies'),
    [
        # Seen from half a turn around the middle the other two would be swapped.
        (swapped(0, 3, BEACONS), NoFixReason.AMBIGUOUS, None, 1.0, {(1, SWAPPED), (4, SWAPPED)}),
        ([*BEACONS[:2], moved(BEACONS[2], x=1.6, y=0.2)], NoFixReason.INCONSISTENT, [1, 2, 3], 0.25, {(3, MOVED)}),
    ],
    ids=['opposite lamps of a square swapped', 'three lamps with one moved'],
)
def test_what_is_ambiguous_is_no_pose_unless_one_is_expected(seen, reason, ids, spread, anomalies):
    pose = SE2(0.7, 1.0, 0.3)
    answer = locate(BEACONS, seen, pose)
    assert answer.reason is reason
    assert ids is None or [d.id for d in answer.anomalies] == ids
    fix = locate(BEACONS, seen, pose, expected=ExpectedPose(SE2(0.71, 1.0, 0.3), spread * NEARLY))
    assert fix.T_map_base.distance_to(pose) < 1e-6
    assert {(d.id, d.kind) for d in fix.anomalies} == anomalies


def test_two_lamps_alone_do_not_overrule_the_expected_pose():
    pose = SE2(0.7, 1.0, 0.3)
    seen = [BEACONS[0], moved(BEACONS[2], y=1.0)]
    answer = locate(BEACONS, seen, pose, expected=ExpectedPose(pose, NEARLY / 100.0))
    assert answer.reason is NoFixReason.UNEXPECTED


def test_two_lamps_of_different_height_may_fit_two_poses():
    beacons = [Beacon(1, (0.0, 0.0, 3.0), 0.03), Beacon(2, (0.3, 0.0, 2.0), 0.03)]
    poses = [SE2(x, 0.3, 0.0) for x in np.arange(-1.5, 1.5, 0.1)]
    answers = [(locate(beacons, beacons, pose), pose) for pose in poses]
    reasons = [answer.reason for answer, _ in answers if isinstance(answer, NoBeaconFix)]
    assert set(reasons) == {NoFixReason.AMBIGUOUS}
    fixes = [(answer, pose) for answer, pose in answers if isinstance(answer, BeaconFix)]
    assert all(fix.T_map_base.distance_to(pose) < 1e-4 for fix, pose in fixes)


@pytest.mark.parametrize(
    ('seen', 'reason', 'anomalies'),
    [
        ([], NoFixReason.NO_LAMP, []),
        (BEACONS[:1], NoFixReason.TOO_FEW_LAMPS, []),
        ([moved(BEACONS[0], x=0.5), BEACONS[0]], NoFixReason.TOO_FEW_LAMPS, [(1, DUPLICATED)] * 2),
        ([Beacon(9, (0.5, 0.5, 2.8), 0.03)], NoFixReason.NO_LAMP, []),
    ],
)
def test_too_few_lamps_are_no_fix(seen, reason, anomalies):
    answer = locate(BEACONS, seen, SE2(0.7, 1.0, 0.3))
    assert answer.reason is reason
    assert [(anomaly.id, anomaly.kind) for anomaly in answer.anomalies] == anomalies


def test_a_rolling_shutter_on_a_robot_that_drives_and_turns():
    # Lamps of later rows are seen from farther on: without the motions the pose is off by centimetres.
    pose, velocity, row_time = SE2(0.7, 1.0, 0.3), (0.8, 0.1, 0.7), 2e-5
    rows = pixels_of(UNEVEN, pose)[:, 1]
    for _ in range(20):
        arcs = [SE2.exp(*(row * row_time * np.array(velocity))) for row in rows]
        pixels = pixels_of(UNEVEN, pose, motions=np.array([(arc.x, arc.y, arc.yaw) for arc in arcs]))
        if np.abs(pixels[:, 1] - rows).max() < 1e-6:
            break
        rows = pixels[:, 1]
    locator = BeaconLocator(UNEVEN, MOUNT, None, PoseSettings())
    motions = row_motions(pixels[:, 1], row_time, velocity)
    ids = [beacon.id for beacon in UNEVEN]
    known = locator.locate(locator.rays(CAMERA, ids, pixels, np.full(5, 0.1), motions))
    assert known.T_map_base.distance_to(pose) < 1e-4
    still = locator.locate(locator.rays(CAMERA, ids, pixels, np.full(5, 5.0)))
    assert still.T_map_base.distance_to(pose) > 0.003
