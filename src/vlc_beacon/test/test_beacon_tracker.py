import math
from dataclasses import replace

import numpy as np
import pytest
from lamp_room import BEACONS, CAMERA, MOUNT, normalised_square, pixels_of

from shirube_core.geometry import SE2, wrap_angle
from vlc_beacon.core.pose.beacon_tracker import LOST_IMAGES, BeaconTracker
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconFix, NoBeaconFix
from vlc_beacon.core.settings import OdometrySettings

STEP = 0.4 / 20.0
SCALE, BEND = 1.02, math.radians(0.2)


ORIGIN, START = SE2(0.0, 0.0, 0.0), SE2(0.9, 0.9, 0.3)


def track(tracker, odometry, pose, hung, rng, noise=0.2):
    """Return what a tracker makes of odometry and of lamps that are seen from a pose."""
    tracker.add_odometry(odometry)
    if not hung:
        return tracker.track(tracker.locator.rays(CAMERA, [], np.empty((0, 2)), []))
    pixels = pixels_of(hung, pose) + noise * rng.normal(size=(len(hung), 2))
    return tracker.track(tracker.locator.rays(CAMERA, [b.id for b in hung], pixels, np.full(len(hung), noise)))


def drive(count, seed=1):
    """Yield true poses on a winding way about the room and the odometry, which is off by 2 % and 0.2 degrees/m."""
    pose, odometry = START, ORIGIN
    for k in range(count):
        yield pose, odometry
        far = math.hypot(0.9 - pose.x, 0.9 - pose.y)
        home = wrap_angle(math.atan2(0.9 - pose.y, 0.9 - pose.x) - pose.yaw)
        turn = np.clip(1.5 * home if far > 1.4 else math.sin(0.03 * k + seed), -0.8, 0.8) / 20.0
        pose = pose @ SE2(STEP, 0.0, turn)
        odometry = odometry @ SE2(SCALE * STEP, 0.0, SCALE * turn + BEND * STEP)


@pytest.mark.parametrize('seed', [1, 2, 3])
@pytest.mark.newest_set_only
def test_one_lamp_and_odometry_carry_on_over_gaps(seed):
    rng = np.random.default_rng(seed)
    tracker, errors, normalised = BeaconTracker(BEACONS, MOUNT), [], []
    for k, (pose, odometry) in enumerate(drive(600, seed)):
        hung = BEACONS if k < 20 else BEACONS[k // 120 % 4 :][:1] if k // 60 % 2 else []
        fix = track(tracker, odometry, pose, hung, rng)
        assert isinstance(fix, BeaconFix)
        errors.append(fix.T_map_base.distance_to(pose))
        normalised.append(normalised_square(fix.T_map_base, fix.covariance[:2, :2], pose))
    assert max(errors) < 0.03
    assert np.mean(normalised) < 1.5


@pytest.mark.parametrize('seed', [1, 2, 3])
@pytest.mark.newest_set_only
def test_errors_with_wheel_slip_match_the_covariance(seed):
    rng = np.random.default_rng(seed)
    settings = OdometrySettings(slip=0.004, turn_slip=0.035)
    tracker = BeaconTracker(BEACONS, MOUNT, odometry_settings=settings)
    odometry, before, normalised = ORIGIN, START, []
    for k, (pose, _) in enumerate(drive(900, seed)):
        motion, before = before.inverse() @ pose, pose
        # Wheels 0.2 m apart slip by 5 mm after a metre, each by itself.
        left, right = 0.005 * math.sqrt(STEP) * rng.normal(size=2)
        slip = SE2(0.5 * (left + right), 0.0, (right - left) / 0.2)
        odometry = odometry @ (motion @ slip)
        hung = BEACONS[k // 120 % 4 :][:2] if k // 40 % 2 == 0 else []
        fix = track(tracker, odometry, pose, hung, rng)
        if isinstance(fix, BeaconFix):
            normalised.append(normalised_square(fix.T_map_base, fix.planar_covariance, pose))
    assert len(normalised) > 700
    assert np.mean(normalised) < 1.5


def test_dead_reckoning_is_published_up_to_the_gap_distance_and_one_lamp_restores_it():
    rng = np.random.default_rng(8)
    tracker = BeaconTracker(BEACONS, MOUNT, odometry_settings=OdometrySettings(gap_distance_max=0.5))
    way, last = 0.0, None
    for k, (pose, odometry) in enumerate(drive(120)):
        hung = BEACONS if k < 20 else BEACONS[:1] if k == 119 else []
        fix = track(tracker, odometry, pose, hung, rng)
        way = 0.0 if k < 20 or last is None else way + SCALE * STEP + 0.3 * abs(last.yaw_to(odometry))
        last = odometry
        assert isinstance(fix, BeaconFix) == (way <= 0.5 or k == 119)
    assert fix.T_map_base.distance_to(pose) < 0.05


def test_one_noisy_image_does_not_throw_the_pose_about():
    rng, tracker = np.random.default_rng(7), BeaconTracker(BEACONS, MOUNT)
    for k, (pose, odometry) in enumerate(drive(120)):
        fix = track(tracker, odometry, pose, BEACONS, rng, noise=2.0 if k > 60 and k % 2 else 0.1)
        assert k < 60 or fix.T_map_base.distance_to(pose) < 0.008


def test_two_lamps_seen_one_after_the_other_are_a_start():
    rng, tracker, answers = np.random.default_rng(4), BeaconTracker(BEACONS, MOUNT), []
    for k, (pose, odometry) in enumerate(drive(80)):
        answers.append(track(tracker, odometry, pose, [BEACONS[0 if k < 40 else 3]], rng))
        if isinstance(answers[-1], BeaconFix):
            assert answers[-1].T_map_base.distance_to(pose) < 0.06
    assert all(isinstance(answer, NoBeaconFix) for answer in answers[:40])
    assert all(isinstance(answer, BeaconFix) for answer in answers[45:])


def test_a_robot_that_was_carried_away_is_found_again():
    rng, tracker = np.random.default_rng(5), BeaconTracker(BEACONS, MOUNT)
    for pose in (SE2(0.5, 0.6, 0.1), SE2(1.2, 1.1, 2.0)):
        for _ in range(5):
            fix = track(tracker, ORIGIN, pose, BEACONS, rng)
            assert fix.T_map_base.distance_to(pose) < 0.02


def test_a_pose_without_lamps_is_given_up_in_the_end():
    rng, tracker, answers = np.random.default_rng(6), BeaconTracker(BEACONS, MOUNT), []
    for k, (pose, odometry) in enumerate(drive(1500)):
        answers.append(track(tracker, odometry, pose, BEACONS if k == 0 else [], rng))
    assert isinstance(answers[60], BeaconFix)
    assert isinstance(answers[-1], NoBeaconFix)


ELSEWHERE = [replace(BEACONS[1], xyz=xyz) for xyz in ((0.4, 1.6, 2.8), (0.6, 0.7, 2.8))]


@pytest.mark.parametrize(
    ('hung', 'kind'), [(ELSEWHERE[:1], AnomalyKind.MOVED), ([BEACONS[1], ELSEWHERE[1]], AnomalyKind.DUPLICATED)]
)
def test_a_single_lamp_in_the_wrong_place_is_named_and_no_new_start(hung, kind):
    rng = np.random.default_rng(7)
    tracker, pose = BeaconTracker(BEACONS, MOUNT), SE2(0.8, 1.0, 0.4)
    track(tracker, ORIGIN, pose, BEACONS, rng)
    for _ in range(2 * LOST_IMAGES):
        fix = track(tracker, ORIGIN, pose, hung, rng)
        assert fix.T_map_base.distance_to(pose) < 0.02
        assert [(anomaly.id, anomaly.kind) for anomaly in fix.anomalies] == [(2, kind)]
        # The doubted lamp is far off, the other one is not.
        distances = np.hypot(*fix.residuals.T)
        assert distances[fix.anomalies[0].observation] > 20.0
        assert (distances[fix.used] < 4.0).all()


CORRIDOR = [Beacon(i + 1, (1.8 * i, 0.9 * (i % 2), 2.8), 0.0325) for i in range(8)]
HALL = [SE2(0.9, 0.4, 0.1), SE2(9.0, 0.4, 0.3)]


def two_lamps_near(pose):
    return sorted(CORRIDOR, key=lambda lamp: math.dist(lamp.xyz[:2], (pose.x, pose.y)))[:2]


@pytest.mark.parametrize(
    ('poses', 'odometry'),
    [(HALL, (ORIGIN, ORIGIN)), ((HALL[0], HALL[0]), (SE2(4.0, -3.0, 1.0), ORIGIN))],
    ids=['robot carried away', 'odometry began again'],
)
def test_two_lamps_that_are_not_in_place_for_long_are_a_new_start(poses, odometry):
    rng, tracker = np.random.default_rng(8), BeaconTracker(CORRIDOR, MOUNT)
    for pose, T_odom_base in zip(poses, odometry, strict=True):
        for _ in range(LOST_IMAGES + 2):
            fix = track(tracker, T_odom_base, pose, two_lamps_near(pose), rng)
        assert isinstance(fix, BeaconFix)
        assert fix.used.all()
        assert fix.T_map_base.distance_to(pose) < 0.05


def test_a_known_height_stays():
    rng, tracker = np.random.default_rng(10), BeaconTracker(BEACONS, MOUNT, 0.0)
    for k, (pose, odometry) in enumerate(drive(200)):
        fix = track(tracker, odometry, pose, BEACONS[: 4 if k < 20 else 1], rng)
        assert isinstance(fix, BeaconFix)
        assert fix.height == pytest.approx(0.0, abs=1e-12)
        assert fix.covariance[2, 2] == pytest.approx(0.0, abs=1e-15)
