"""State between pairs, tested with a localizer that records its calls."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from located_pairs import with_fix, without_fix
from place_scenes import MOUNT
from random_places import random_place
from taught_wall import CALIBRATIONS, HERE, RAW, TAUGHT, raw_image, seen, taught_place

from shirube_core.geometry import SE2, LensModel
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.pair import pair_stream
from stereo_landmark.core.pair.camera_pair import Side, StampSynchronizer
from stereo_landmark.core.pair.pair_stream import PairStream, recalibrate
from stereo_landmark.core.pair.rectification_check import PairCheck, PairFault
from stereo_landmark.core.settings import LandmarkSettings, PairSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

SECOND = 1_000_000_000


@pytest.fixture
def asked(monkeypatch):
    """The tilt and the prior of every call; all but the third return a fix, each 1 cm farther than the one before."""
    questions = []

    def locate(self, left, right, tilt, prior):
        questions.append((tilt, prior))
        fix = with_fix().result
        there = replace(fix.displacement, T_place_base=SE2(0.01 * len(questions), 0.0, 0.0))
        return without_fix().result if len(questions) == 3 else replace(fix, displacement=there)

    monkeypatch.setattr(LandmarkLocalizer, 'locate', locate)
    return questions


def stream():
    return PairStream([taught_place()], MOUNT, PairSettings(), LandmarkSettings())


def add_pair(to, seconds, calibrations=CALIBRATIONS):
    alone, located = (
        to.add_image(side, round(seconds * SECOND), image, calibration)
        for side, image, calibration in zip(Side, seen(TAUGHT), calibrations)
    )
    assert alone is None
    return located


def test_raw_images_of_fisheye_lenses_give_the_pose():
    lens = {'distortion': (-0.012, 0.021, -0.018, 0.004), 'model': LensModel.EQUIDISTANT}
    wide = [replace(each, raw=replace(each.raw, **lens)) for each in RAW]
    robot = PairStream([taught_place()], MOUNT, PairSettings(rectify=True), LandmarkSettings())
    for side, image, calibration in zip(Side, seen(HERE), wide):
        located = robot.add_image(side, SECOND, raw_image(image, calibration), calibration)
    found = located.result.displacement.T_place_base
    assert (found.x, found.y, found.yaw) == pytest.approx((HERE[0], HERE[1], HERE[3]), abs=0.004)


def test_the_place_of_late_is_asked_first_until_it_is_forgotten_or_long_ago(asked):
    robot = stream()
    for seconds in (0.0, 1.0, 2.0, 3.0):
        add_pair(robot, seconds)
    assert [prior and prior.place for _, prior in asked] == [None, 'wall', 'wall', 'wall']
    robot.drop_prior()
    for seconds in (4.0, 5.0, 20.0):
        add_pair(robot, seconds)
    assert [prior and prior.place for _, prior in asked[4:]] == [None, 'wall', None]


def test_the_pose_is_predicted_at_constant_velocity_for_a_short_time(asked):
    robot = stream()
    for seconds in (0.0, 0.1, 0.3, 0.4, 5.0):
        add_pair(robot, seconds)
    states = [None if prior is None or prior.state is None else prior.state for _, prior in asked]
    assert states[0] is None
    assert states[4] is None
    assert [float(states[i][0]) for i in (1, 2, 3)] == pytest.approx([0.01, 0.04, 0.05])


def test_the_tilt_near_the_image_counts_and_without_one_the_robot_is_level(asked):
    robot = stream()
    robot.add_tilt(0.99, 0.02, -0.01)
    is_missing = [add_pair(robot, seconds).is_tilt_missing for seconds in (1.0, 2.0)]
    assert [tilt for tilt, _ in asked] == [(0.02, -0.01), (0.0, 0.0)]
    assert is_missing == [False, True]
    assert not add_pair(stream(), 1.0).is_tilt_missing


def test_cameras_of_a_lost_robot_are_checked_now_and_then_and_faulty_ones_with_each_pair(monkeypatch):
    checked = []

    def fault(*_):
        checked.append(None)
        return PairCheck(50, 0.0, 0.0, PairFault.SWAPPED if len(checked) in {2, 3} else None)

    monkeypatch.setattr(pair_stream, 'check_pair', fault)
    monkeypatch.setattr(LandmarkLocalizer, 'locate', lambda *_: without_fix().result)
    robot = stream()
    counts = []
    for seconds in range(7):
        fault = pytest.raises(StereoLandmarkError, match='swapped') if seconds in {3, 4} else nullcontext()
        with fault:
            add_pair(robot, seconds)
        counts.append(len(checked))
    assert counts == [1, 1, 1, 2, 3, 4, 4]


def test_a_calibration_that_changes_is_checked_again(asked):
    robot = stream()
    add_pair(robot, 0.0)
    wider = replace(
        CALIBRATIONS[1], projection=(*CALIBRATIONS[1].projection[:3], -99.0, *CALIBRATIONS[1].projection[4:])
    )
    with pytest.raises(StereoLandmarkError, match='place wall was taught with baseline'):
        add_pair(robot, 1.0, (CALIBRATIONS[0], wider))
    add_pair(robot, 2.0)
    assert len(asked) == 2


PLACE = random_place(1)
RIG = PLACE.rig


def test_a_new_calibration_of_the_same_cameras_keeps_the_points_in_space():
    focal = {'fx': 1.02 * RIG.left.fx, 'fy': 1.02 * RIG.left.fy}
    other = replace(RIG, left=replace(RIG.left, **focal), right=replace(RIG.right, **focal))
    place = recalibrate(PLACE, other)
    assert place.rig == other
    assert (place.coordinates.positions == PLACE.coordinates.positions).all()


@pytest.mark.parametrize(
    ('other', 'name'),
    [
        (replace(RIG, baseline=RIG.baseline * 1.1), 'baseline'),
        (replace(RIG, left=replace(RIG.left, width=99), right=replace(RIG.right, width=99)), 'image size'),
        (replace(RIG, mount=replace(RIG.mount, xyz=(0.0, 0.0, 9.0))), 'camera_xyz'),
        (replace(RIG, mount=replace(RIG.mount, rpy=(0.0, 0.0, 0.0))), 'camera_rpy'),
    ],
)
def test_another_rig_is_refused(other, name):
    with pytest.raises(StereoLandmarkError, match=f'hall was taught with {name} '):
        recalibrate(PLACE, other)


MILLISECOND = 1_000_000


def run(pairing, *arrivals):
    """Return the pairs of stamps for arrivals of (side, stamp [ms])."""
    pairs = (pairing.add(side, stamp * MILLISECOND, stamp) for side, stamp in arrivals)
    return [pair for pair in pairs if pair is not None]


EQUAL = [(0, 0), (1, 0), (1, 50), (0, 50), (0, 100), (0, 150), (1, 100), (1, 150)]
NEAR = [(0, 0), (1, 4), (0, 50), (1, 57), (1, 104), (0, 100)]
SEVERAL = [(0, 0), (0, 10), (0, 25), (1, 12)]


@pytest.mark.parametrize(
    ('arrivals', 'tolerance', 'queue_size', 'pairs'),
    [
        (EQUAL, 0, 5, [(0, 0), (50, 50), (100, 100), (150, 150)]),
        (NEAR, 5, 5, [(0, 4), (100, 104)]),
        (NEAR, 0, 9, []),
        (SEVERAL, 20, 5, [(10, 12)]),
    ],
)
def test_the_nearest_stamps_within_the_tolerance_make_pairs_left_first(arrivals, tolerance, queue_size, pairs):
    assert run(StampSynchronizer(tolerance * MILLISECOND, queue_size), *arrivals) == pairs


def test_every_image_is_in_one_pair_at_most_though_some_are_lost():
    rng = np.random.default_rng(5)
    arrivals = sorted(
        (stamp + rng.integers(0, 120), side, stamp)
        for stamp in range(0, 3000, 50)
        for side in (0, 1)
        if rng.random() > 0.2
    )
    by_side = [sorted(s for _, side, s in arrivals if side == k) for k in (0, 1)]
    order = {k: iter(by_side[k]) for k in (0, 1)}
    pairs = run(StampSynchronizer(0, 20), *((side, next(order[side])) for _, side, _ in arrivals))
    assert pairs == [(s, s) for s in by_side[0] if s in by_side[1]]


@pytest.mark.parametrize(
    ('arrivals', 'words'),
    [
        (((side, 100 * k + 7 * side) for k in range(5) for side in (0, 1)), 'no stamps in common; .*approximate_sync'),
        (((1, 100 * k) for k in range(5)), 'right images are received, but no left images'),
    ],
)
def test_inputs_without_common_stamps_or_without_a_camera_are_reported(arrivals, words):
    with pytest.raises(StereoLandmarkError, match=words):
        run(StampSynchronizer(0, 3), *arrivals)
