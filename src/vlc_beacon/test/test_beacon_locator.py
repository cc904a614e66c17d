import math
from dataclasses import replace

import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, UNEVEN, pixels_of, random_pose

from shirube_core.geometry import SE2, PinholeCamera
from vlc_beacon.core.pose.beacon_locator import BeaconLocator
from vlc_beacon.core.pose.lamp_rays import Beacon, row_motions
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconFix, ExpectedPose, NoBeaconFix, NoFixReason
from vlc_beacon.core.settings import PoseSettings

EXACT = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.0)
NEARLY = np.diag([0.05**2, 0.05**2, 0.05**2])


def locate(
    beacons,
    seen,
    pose,
    *,
    noise=0.0,
    rng=None,
    known_height=None,
    settings=EXACT,
    expected=None,
    tilt=(0.0, 0.0),
):
    """Locate a robot; ``seen`` are beacons as they really hang, with the ids that they play."""
    locator = BeaconLocator(beacons, MOUNT, known_height, settings)
    pixels = pixels_of(seen, pose, tilt=tilt)
    if noise:
        pixels = pixels + noise * rng.normal(size=pixels.shape)
    rays = locator.rays(CAMERA, [b.id for b in seen], pixels, np.full(len(seen), noise or 0.05))
    return locator.locate(rays, tilt, expected)


@pytest.mark.parametrize('beacons', [BEACONS, UNEVEN])
def test_exact_centres_give_the_exact_pose(beacons):
    rng = np.random.default_rng(1)
    for _ in range(20):
        pose, tilt = random_pose(rng), tuple(rng.normal(size=2) * 0.05)
        fix = locate(beacons, beacons, pose, tilt=tilt)
        assert fix.T_map_base.distance_to(pose) < 1e-7
        assert fix.T_map_base.yaw_to(pose) == pytest.approx(0.0, abs=1e-7)
        assert fix.height == pytest.approx(0.0, abs=1e-7)
        assert fix.anomalies == ()


def test_the_pose_follows_every_motion_of_the_map():
    rng = np.random.default_rng(2)
    pose, motion = random_pose(rng), SE2(3.0, -2.0, 1.9)
    moved = [replace(b, xyz=(*motion.transform([b.xyz[:2]])[0].tolist(), b.xyz[2] + 0.7)) for b in UNEVEN]
    locator, other = BeaconLocator(UNEVEN, MOUNT), BeaconLocator(moved, MOUNT)
    pixels = pixels_of(UNEVEN, pose) + 0.2 * rng.normal(size=(5, 2))
    rays = locator.rays(CAMERA, [1, 2, 3, 4, 5], pixels, np.full(5, 0.2))
    here, there = locator.locate(rays), other.locate(rays)
    assert there.T_map_base.distance_to(motion @ here.T_map_base) < 1e-6
    assert there.height == pytest.approx(here.height + 0.7, abs=1e-6)


@pytest.mark.parametrize('count', [2, 3, 4])
def test_a_robot_that_looks_backwards_has_one_pose(count):
    rng = np.random.default_rng(8)
    for _ in range(30):
        pose = SE2(*rng.uniform(0.5, 1.3, 2), math.pi)
        fix = locate(UNEVEN, UNEVEN[:count], pose, noise=0.1, rng=rng)
        if count > 2 or isinstance(fix, BeaconFix):
            assert abs(fix.T_map_base.yaw_to(pose)) < 0.02
        fix = locate(BEACONS, BEACONS[:count], pose, noise=0.1, rng=rng)
        assert fix.T_map_base.distance_to(pose) < 0.02


@pytest.mark.parametrize('height', [None, 0.0])
@pytest.mark.parametrize('count', [2, 4])
@pytest.mark.newest_set_only
def test_errors_are_those_of_the_cramer_rao_bound(height, count):
    rng = np.random.default_rng(3)
    normalised = []
    for _ in range(250):
        pose = random_pose(rng)
        fix = locate(BEACONS, BEACONS[:count], pose, noise=0.3, rng=rng, known_height=height)
        error = np.array(
            [fix.T_map_base.x - pose.x, fix.T_map_base.y - pose.y, fix.height, pose.yaw_to(fix.T_map_base)]
        )
        keep = [0, 1, 3] if height == 0.0 else [0, 1, 2, 3]
        normalised.append(
            error[keep] @ np.linalg.solve(fix.covariance[np.ix_(keep, keep)], error[keep]) / len(keep)
        )
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.2)


@pytest.mark.newest_set_only
def test_the_covariance_knows_of_tilt():
    rng = np.random.default_rng(4)
    settings = PoseSettings(pixel_sigma=0.0, beacon_sigma=0.0, tilt_sigma=0.005)
    normalised = []
    for _ in range(250):
        pose, tilt = random_pose(rng), 0.005 * rng.normal(size=2)
        locator = BeaconLocator(BEACONS, MOUNT, None, settings)
        pixels = pixels_of(BEACONS, pose, tilt=tilt) + 0.3 * rng.normal(size=(4, 2))
        fix = locator.locate(locator.rays(CAMERA, [1, 2, 3, 4], pixels, np.full(4, 0.3)))
        error = np.array([fix.T_map_base.x - pose.x, fix.T_map_base.y - pose.y])
        normalised.append(error @ np.linalg.solve(fix.covariance[:2, :2], error) / 2.0)
    assert np.mean(normalised) == pytest.approx(1.0, abs=0.2)


def test_tilt_error_matches_the_geometry():
    pose = SE2(0.9, 0.9, 0.0)
    pixels = pixels_of(BEACONS, pose, tilt=(math.radians(0.5), 0.0))
    locator = BeaconLocator(BEACONS, MOUNT, None, PoseSettings(tilt_sigma=0.0))
    rays = locator.rays(CAMERA, [1, 2, 3, 4], pixels, np.full(4, 0.5))
    assert locator.locate(rays, (math.radians(0.5), 0.0)).T_map_base.distance_to(pose) < 1e-6
    unmodelled = locator.locate(rays).T_map_base.distance_to(pose)
    assert unmodelled == pytest.approx(2.8 * math.radians(0.5), rel=0.5)


def test_a_distorting_lens_is_undone():
    camera = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5, (-0.2, 0.05, 0.001, -0.001, 0.0))
    pose = SE2(0.6, 1.1, 0.4)
    locator = BeaconLocator(BEACONS, MOUNT, None, EXACT)
    rays = locator.rays(camera, [1, 2, 3, 4], pixels_of(BEACONS, pose, camera=camera), np.full(4, 0.1))
    assert locator.locate(rays).T_map_base.distance_to(pose) < 1e-6


def test_a_moved_lamp_is_named():
    rng = np.random.default_rng(5)
    for name in range(5):
        pose = random_pose(rng)
        seen = [
            replace(b, xyz=(b.xyz[0] + 0.15, *b.xyz[1:])) if i == name else b for i, b in enumerate(UNEVEN)
        ]
        fix = locate(UNEVEN, seen, pose, noise=0.2, rng=rng)
        assert fix.T_map_base.distance_to(pose) < 0.02
        (anomaly,) = fix.anomalies
        assert (anomaly.id, anomaly.kind) == (UNEVEN[name].id, AnomalyKind.MOVED)


def test_swapped_lamps_are_named():
    rng = np.random.default_rng(6)
    pose = random_pose(rng)
    for first, second in ((0, 1), (1, 3), (0, 3)):
        seen = list(UNEVEN)
        seen[first] = replace(UNEVEN[first], xyz=UNEVEN[second].xyz)
        seen[second] = replace(UNEVEN[second], xyz=UNEVEN[first].xyz)
        fix = locate(UNEVEN, seen, pose, noise=0.2, rng=rng)
        assert fix.T_map_base.distance_to(pose) < 0.02
        assert {(d.id, d.kind, d.swapped_with) for d in fix.anomalies} == {
            (first + 1, AnomalyKind.SWAPPED, second + 1),
            (second + 1, AnomalyKind.SWAPPED, first + 1),
        }


def test_opposite_lamps_of_a_square_swapped_are_no_pose_unless_one_is_expected():
    # Seen from half a turn around the middle the other two would be swapped.
    pose = SE2(0.7, 1.0, 0.3)
    seen = [replace(BEACONS[0], xyz=BEACONS[3].xyz), *BEACONS[1:3], replace(BEACONS[3], xyz=BEACONS[0].xyz)]
    answer = locate(BEACONS, seen, pose)
    assert isinstance(answer, NoBeaconFix)
    assert answer.reason is NoFixReason.AMBIGUOUS
    fix = locate(BEACONS, seen, pose, expected=ExpectedPose(SE2(0.72, 1.0, 0.3), NEARLY))
    assert fix.T_map_base.distance_to(pose) < 1e-6
    assert {d.id for d in fix.anomalies} == {1, 4}


def test_a_duplicated_lamp_is_reported():
    rng = np.random.default_rng(7)
    pose = random_pose(rng)
    copy = Beacon(3, (0.4, 0.6, 2.8), 0.0325)
    fix = locate(BEACONS, [*BEACONS, copy], pose, noise=0.2, rng=rng)
    assert fix.T_map_base.distance_to(pose) < 0.02
    (anomaly,) = fix.anomalies
    assert (anomaly.id, anomaly.kind, anomaly.observation) == (3, AnomalyKind.DUPLICATED, 4)


def test_three_lamps_with_one_moved_are_ambiguous_without_an_expected_pose():
    pose = SE2(0.7, 1.0, 0.3)
    seen = [*BEACONS[:2], replace(BEACONS[2], xyz=(1.6, 0.2, 2.8))]
    answer = locate(BEACONS, seen, pose)
    assert isinstance(answer, NoBeaconFix)
    assert answer.reason is NoFixReason.INCONSISTENT
    assert [d.id for d in answer.anomalies] == [1, 2, 3]
    fix = locate(BEACONS, seen, pose, expected=ExpectedPose(SE2(0.71, 1.0, 0.3), NEARLY / 4.0))
    assert fix.T_map_base.distance_to(pose) < 1e-6
    assert [(d.id, d.kind) for d in fix.anomalies] == [(3, AnomalyKind.MOVED)]


def test_two_lamps_alone_do_not_overrule_the_expected_pose():
    pose = SE2(0.7, 1.0, 0.3)
    seen = [BEACONS[0], replace(BEACONS[2], xyz=(1.8, 1.0, 2.8))]
    answer = locate(BEACONS, seen, pose, expected=ExpectedPose(pose, NEARLY / 100.0))
    assert isinstance(answer, NoBeaconFix)
    assert answer.reason is NoFixReason.UNEXPECTED


def test_two_lamps_of_different_height_may_fit_two_poses():
    beacons = [Beacon(1, (0.0, 0.0, 3.0), 0.03), Beacon(2, (0.3, 0.0, 2.0), 0.03)]
    answers = [locate(beacons, beacons, SE2(x, 0.3, 0.0)) for x in np.arange(-1.5, 1.5, 0.1)]
    ambiguous = [a for a in answers if isinstance(a, NoBeaconFix) and a.reason is NoFixReason.AMBIGUOUS]
    assert ambiguous
    assert all(isinstance(a, BeaconFix) or a in ambiguous for a in answers)
    for x, answer in zip(np.arange(-1.5, 1.5, 0.1), answers):
        if isinstance(answer, BeaconFix):
            assert answer.T_map_base.distance_to(SE2(x, 0.3, 0.0)) < 1e-4


@pytest.mark.parametrize(
    ('seen', 'known_height', 'reason'),
    [
        ([], None, NoFixReason.NO_LAMP),
        (BEACONS[:1], None, NoFixReason.TOO_FEW_LAMPS),
        ([BEACONS[0], BEACONS[0]], None, NoFixReason.TOO_FEW_LAMPS),
        ([Beacon(9, (0.5, 0.5, 2.8), 0.03)], None, NoFixReason.NO_LAMP),
    ],
)
def test_too_few_lamps_are_no_fix(seen, known_height, reason):
    locator = BeaconLocator(BEACONS, MOUNT, known_height)
    pixels = pixels_of(seen, SE2(0.7, 1.0, 0.3)) if seen else np.empty((0, 2))
    rays = locator.rays(CAMERA, [b.id for b in seen], pixels, np.full(len(seen), 0.1))
    assert locator.locate(rays).reason is reason


def test_two_images_of_one_lamp_alone_are_named():
    answer = locate(BEACONS, [BEACONS[0], Beacon(1, (0.5, 0.9, 2.8), 0.0325)], SE2(0.7, 1.0, 0.3))
    assert answer.reason is NoFixReason.TOO_FEW_LAMPS
    assert [(anomaly.id, anomaly.kind) for anomaly in answer.anomalies] == [(1, AnomalyKind.DUPLICATED)] * 2


def test_a_rolling_shutter_on_a_robot_that_drives_and_turns():
    # Lamps of later rows are seen from farther on: without the motions the pose is off by centimetres.
    pose, velocity, row_time = SE2(0.7, 1.0, 0.3), (0.8, 0.1, 0.7), 2e-5
    rows = pixels_of(UNEVEN, pose)[:, 1]
    for _ in range(20):
        arcs = []
        for row in rows:
            moved, small = SE2(0.0, 0.0, 0.0), row * row_time / 200.0
            for _ in range(200):
                moved = moved @ SE2(*(small * np.array(velocity)))
            arcs.append((moved.x, moved.y, moved.yaw))
        pixels = pixels_of(UNEVEN, pose, motions=np.array(arcs))
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
