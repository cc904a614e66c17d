"""Tracking of a robot that drives, is kidnapped, or has too few dots in view; and the prediction of its pose."""

import math

import numpy as np
import pytest
from floor_views import CAMERA, dots_at, first_dots, is_right, pose_over, see

from floor_localizer.core.fix import Fix, NoFix, NoFixReason
from floor_localizer.core.settings import TrackerSettings
from floor_localizer.core.tracker import FloorTracker, PosePredictor
from shirube_core.geometry import SE2

START = SE2(0.2, 0.3, 0.1)
STEP = SE2(0.01, 0.0, 0.02)
NARROW = np.diag([1e-4, 1e-4, 0.01])


@pytest.fixture
def tracker(localizer):
    return FloorTracker(localizer)


def drive(number, start=START):
    poses = [start]
    for _ in range(number - 1):
        poses.append(poses[-1] @ STEP)
    return poses


@pytest.mark.parametrize('odometry', [True, False])
def test_a_driving_robot_is_tracked_by_prediction(floor, tracker, odometry):
    rng = np.random.default_rng(0)
    odom = SE2(7.0, 7.0, -2.0)
    for k, pose in enumerate(drive(12)):
        if odometry:
            tracker.add_odometry(0.05 * k, odom @ (START.inverse() @ pose))
        result = tracker.track_dots(0.05 * k, see(floor, pose, rng, missing=0.2, spurious=5).dots, CAMERA)
        assert is_right(result, pose)
        assert result.used_prior == (k > 0)


def test_a_kidnapped_robot_is_found_in_the_first_image(floor, tracker):
    rng = np.random.default_rng(1)
    for k, pose in enumerate([*drive(4), *drive(3, SE2(0.7, 0.35, -2.0))]):
        result = tracker.track_dots(0.05 * k, see(floor, pose, rng).dots, CAMERA)
        assert is_right(result, pose)


def test_after_images_without_dots_it_is_found_again(floor, tracker):
    rng = np.random.default_rng(2)
    for k, pose in enumerate(drive(9)):
        blind = 3 <= k < 6
        if blind:
            result = tracker.track(0.05 * k, np.full((235, 235), 128, dtype=np.uint8), CAMERA)
            assert result.reason is NoFixReason.NO_DOTS
        else:
            assert is_right(tracker.track_dots(0.05 * k, see(floor, pose, rng).dots, CAMERA), pose)


def test_an_area_elsewhere_holds_until_it_is_lifted(floor, tracker):
    rng = np.random.default_rng(4)
    tracker.set_area(SE2(0.7, 0.4, 0.1), NARROW)
    for k in range(3):
        result = tracker.track_dots(0.05 * k, see(floor, START, rng).dots, CAMERA)
        assert result.reason is NoFixReason.OUTSIDE_AREA
    tracker.relocalize()
    assert is_right(tracker.track_dots(1.0, see(floor, START, rng).dots, CAMERA), START)


def test_an_area_around_the_robot_leads_to_a_pose_and_then_it_may_leave_it(floor, tracker):
    rng = np.random.default_rng(5)
    tracker.set_area(START @ SE2(0.02, -0.01, 0.1), NARROW)
    result = tracker.track_dots(0.0, see(floor, START, rng).dots, CAMERA)
    assert is_right(result, START)
    assert result.used_prior
    away = SE2(0.7, 0.4, 2.0)
    assert is_right(tracker.track_dots(0.05, see(floor, away, rng).dots, CAMERA), away)


def lenient(localizer):
    return FloorTracker(localizer, TrackerSettings(initialpose_is_strict=False, joined_views=1))


def test_an_area_from_another_localizer_finds_a_sparse_view_and_rejects_no_pose_elsewhere(floor, localizer):
    rng, found = np.random.default_rng(6), 0
    for _ in range(8):
        pose = pose_over(rng)
        dots = first_dots(see(floor, pose, rng, noise=1.0).dots, 7)
        assert isinstance(lenient(localizer).track_dots(0.0, dots, CAMERA), NoFix)
        tracker = lenient(localizer)
        tracker.set_area(pose @ SE2(0.05, -0.03, 0.05), np.diag([2.5e-3, 2.5e-3, 2.5e-3]))
        found += is_right(tracker.track_dots(0.0, dots, CAMERA), pose, 0.002, 0.03)
    assert found >= 6
    # A wrong area: the whole map is searched.
    tracker.set_area(pose @ SE2(0.0, 0.0, math.pi), np.diag([2.5e-3, 2.5e-3, 2.5e-3]))
    assert is_right(tracker.track_dots(0.1, see(floor, pose, rng).dots, CAMERA), pose)


def test_an_area_moves_with_odometry_until_the_robot_is_found(floor, tracker):
    rng = np.random.default_rng(5)
    tracker.set_area(START, np.diag([1e-6, 1e-6, 1e-4]))
    blank, later = np.full((235, 235), 128, dtype=np.uint8), START @ SE2(0.1, 0.05, 0.5)
    tracker.add_odometry(0.0, SE2(7.0, 7.0, 1.0))
    assert tracker.track(0.0, blank, CAMERA).reason is NoFixReason.NO_DOTS
    tracker.add_odometry(0.2, SE2(7.0, 7.0, 1.0) @ START.inverse() @ later)
    assert is_right(tracker.track_dots(0.2, see(floor, later, rng).dots, CAMERA), later)


def sparse_views(floor, rng, number):
    """Views of a driving robot with only the four dots nearest to the centre of the image."""
    for k in range(number):
        pose = START @ SE2(0.012 * k, 0.0, 0.0)
        pixels = see(floor, pose, rng).dots.pixels
        yield pose, dots_at(pixels[np.argsort(np.linalg.norm(pixels - 117.0, axis=1))[:4]])


def test_sparse_views_merged_by_odometry_find_what_none_finds_alone(floor, localizer):
    rng = np.random.default_rng(7)
    tracker = FloorTracker(localizer, TrackerSettings(odometry_error=0.005, joined_views=8))
    found = []
    for k, (pose, dots) in enumerate(sparse_views(floor, rng, 8)):
        assert isinstance(localizer.locate_dots(dots, CAMERA), NoFix)
        tracker.add_odometry(0.1 * k, START.inverse() @ pose)
        result = tracker.track_dots(0.1 * k, dots, CAMERA)
        found.append(isinstance(result, Fix))
        if found[-1]:
            assert is_right(result, pose, position=0.003, heading=0.03)
            assert len(result.matched) == len(result.dots) == 4
    assert any(found)
    assert not found[0]


@pytest.mark.parametrize('is_relocalized', [True, False])
def test_without_odometry_or_after_relocalize_sparse_views_are_not_joined(floor, tracker, is_relocalized):
    for k, (pose, dots) in enumerate(sparse_views(floor, np.random.default_rng(7), 4)):
        if is_relocalized:
            tracker.relocalize()
            tracker.add_odometry(0.1 * k, START.inverse() @ pose)
        assert isinstance(tracker.track_dots(0.1 * k, dots, CAMERA), NoFix)


def test_no_wrong_pose_from_ever_fewer_dots(floor, localizer):
    rng = np.random.default_rng(8)
    for number in (5, 6, 7, 8, 10, 12):
        for _ in range(6):
            pose = pose_over(rng)
            tracker = FloorTracker(localizer)
            result = tracker.track_dots(0.0, first_dots(see(floor, pose, rng).dots, number), CAMERA)
            assert isinstance(result, NoFix) or is_right(result, pose, 0.003, 0.03)


def test_a_first_pose_that_is_not_sure_enough_waits(floor, localizer):
    rng = np.random.default_rng(9)
    never_sure = FloorTracker(localizer, TrackerSettings(chance_alignments_alone_max=0.0))
    dots = first_dots(see(floor, START, rng).dots, 9)
    assert isinstance(localizer.locate_dots(dots, CAMERA), Fix)
    assert never_sure.track_dots(0.0, dots, CAMERA).reason is NoFixReason.UNCERTAIN


@pytest.mark.parametrize('is_dropped', [True, False])
def test_relocalize_and_an_image_stamped_before_the_last_drop_the_prior(floor, tracker, is_dropped):
    rng = np.random.default_rng(10)
    tracker.track_dots(1.0, see(floor, START, rng).dots, CAMERA)
    if is_dropped:
        tracker.relocalize()
    result = tracker.track_dots(1.05 if is_dropped else 0.5, see(floor, START, rng).dots, CAMERA)
    assert is_right(result, START)
    assert not result.used_prior


SETTINGS = TrackerSettings()
ODOM_START = SE2(5.0, -2.0, 2.8)
ODOM_STEP = SE2(0.1, 0.0, 0.6)


def assert_same(found, expected, tolerance=1e-9):
    assert found.distance_to(expected) < tolerance
    assert abs(found.yaw_to(expected)) < tolerance


@pytest.fixture
def predictor():
    predictor = PosePredictor(SETTINGS)
    predictor.add_odometry(10.0, ODOM_START)
    predictor.add_odometry(10.2, ODOM_START @ ODOM_STEP)
    return predictor


@pytest.mark.parametrize('fraction', [0.0, 0.25, 0.5, 1.0, 1.5, 2.0])
def test_odometry_goes_along_an_arc_and_a_little_beyond_the_last_message(predictor, fraction):
    arc = SE2.exp(*(fraction * v for v in ODOM_STEP.log()))
    assert_same(predictor.relative_motion(10.0, 10.0 + 0.2 * fraction), arc)


def test_stale_odometry_gives_no_motion(predictor):
    assert predictor.relative_motion(10.0, 10.5) is None
    assert predictor.relative_motion(9.7, 10.0) is None
    assert PosePredictor(SETTINGS).relative_motion(10.0, 10.1) is None


def test_after_a_jump_of_odometry_the_velocity_leads_on(predictor):
    predictor.add_odometry(10.4, SE2(99.0, 0.0, 0.0))
    assert predictor.relative_motion(10.2, 10.4) is None
    predictor.add_pose(10.1, ODOM_START)
    predictor.add_pose(10.2, ODOM_START @ SE2(0.02, 0.0, 0.0))
    assert_same(predictor.predict(10.4).T_map_base, ODOM_START @ SE2(0.06, 0.0, 0.0))


def test_a_late_message_is_used_and_a_known_stamp_is_left_out(predictor):
    predictor.add_odometry(10.1, ODOM_START @ SE2(0.0, 0.1, 0.0))
    predictor.add_odometry(10.2, SE2(99.0, 0.0, 0.0))
    assert_same(predictor.relative_motion(10.0, 10.1), SE2(0.0, 0.1, 0.0))
    assert_same(predictor.relative_motion(10.0, 10.2), ODOM_STEP)


def test_forth_and_back_is_the_identity_without_poses_too(predictor):
    predictor.clear_poses()
    there, back = predictor.relative_motion(10.0, 10.2), predictor.relative_motion(10.2, 10.0)
    assert_same(there, ODOM_STEP)
    assert_same(there @ back, SE2(0.0, 0.0, 0.0))


def test_nothing_is_predicted_without_a_pose_or_for_the_past(predictor):
    assert predictor.predict(10.1) is None
    predictor.add_pose(10.1, ODOM_START)
    predictor.clear_poses()
    assert predictor.predict(10.2) is None
    predictor.add_pose(10.1, ODOM_START)
    assert predictor.predict(10.0) is None


def test_odometry_leads_on_from_the_last_pose(predictor):
    pose = SE2(-1.0, 0.5, 0.3)
    predictor.add_pose(10.0, pose)
    prior = predictor.predict(10.2)
    assert_same(prior.T_map_base, pose @ ODOM_STEP)
    assert prior.radius == pytest.approx(SETTINGS.still_radius + SETTINGS.odometry_error * 0.1)
    assert prior.yaw_tolerance == pytest.approx(SETTINGS.still_turn + SETTINGS.odometry_error * 0.7)
    assert not prior.is_strict


def test_without_odometry_a_steady_drive_goes_on_and_the_prior_covers_any_within_the_acceleration():
    predictor = PosePredictor(SETTINGS)
    speed, dt = 0.4, 0.05
    for k in range(2):
        predictor.add_pose(k * dt, ODOM_START @ SE2(speed * k * dt, 0.0, 0.0))
    prior = predictor.predict(2 * dt)
    assert_same(prior.T_map_base, ODOM_START @ SE2(speed * 2 * dt, 0.0, 0.0))
    for acceleration in (-SETTINGS.acceleration_max, SETTINGS.acceleration_max):
        assert abs(0.5 * acceleration * dt * dt) <= prior.radius
    assert 0.5 * SETTINGS.turn_acceleration_max * dt * dt <= prior.yaw_tolerance


def test_the_search_radius_grows_until_nothing_is_predicted_and_the_heading_up_to_half_a_turn():
    predictor = PosePredictor(SETTINGS)
    predictor.add_pose(0.0, ODOM_START)
    radii = [predictor.predict(stamp).radius for stamp in (0.0, 0.05, 0.1, 0.2)]
    assert radii == sorted(radii)
    assert predictor.predict(5.0) is None
    predictor = PosePredictor(TrackerSettings(prior_radius_max=10.0))
    predictor.add_pose(0.0, ODOM_START)
    assert predictor.predict(1.0).yaw_tolerance == math.pi
