"""Prediction of the pose from odometry or the last velocity."""

from __future__ import annotations

import math

import pytest

from floor_localizer.core.pose_predictor import PosePredictor
from floor_localizer.core.settings import TrackerSettings
from shirube_core.geometry import SE2

SETTINGS = TrackerSettings()
START = SE2(5.0, -2.0, 2.8)
STEP = SE2(0.1, 0.0, 0.6)


def assert_same(found, expected, tolerance=1e-9):
    assert found.distance_to(expected) < tolerance
    assert abs(found.yaw_to(expected)) < tolerance


@pytest.fixture
def predictor():
    predictor = PosePredictor(SETTINGS)
    predictor.add_odometry(10.0, START)
    predictor.add_odometry(10.2, START @ STEP)
    return predictor


@pytest.mark.parametrize('fraction', [0.0, 0.25, 0.5, 1.0, 1.5, 2.0])
def test_odometry_goes_along_an_arc_and_a_little_beyond_the_last_message(predictor, fraction):
    arc = SE2.exp(*(fraction * v for v in STEP.log()))
    assert_same(predictor.relative_motion(10.0, 10.0 + 0.2 * fraction), arc)


def test_stale_odometry_gives_no_motion(predictor):
    assert predictor.relative_motion(10.0, 10.5) is None
    assert predictor.relative_motion(9.7, 10.0) is None
    assert PosePredictor(SETTINGS).relative_motion(10.0, 10.1) is None


def test_after_a_jump_of_odometry_the_velocity_leads_on(predictor):
    predictor.add_odometry(10.4, SE2(99.0, 0.0, 0.0))
    assert predictor.relative_motion(10.2, 10.4) is None
    predictor.add_pose(10.1, START)
    predictor.add_pose(10.2, START @ SE2(0.02, 0.0, 0.0))
    assert_same(predictor.predict(10.4).T_map_base, START @ SE2(0.06, 0.0, 0.0))


def test_a_late_message_is_used_and_a_known_stamp_is_left_out(predictor):
    predictor.add_odometry(10.1, START @ SE2(0.0, 0.1, 0.0))
    predictor.add_odometry(10.2, SE2(99.0, 0.0, 0.0))
    assert_same(predictor.relative_motion(10.0, 10.1), SE2(0.0, 0.1, 0.0))
    assert_same(predictor.relative_motion(10.0, 10.2), STEP)


def test_forth_and_back_is_the_identity(predictor):
    there, back = predictor.relative_motion(10.0, 10.2), predictor.relative_motion(10.2, 10.0)
    assert_same(there, STEP)
    assert_same(there @ back, SE2(0.0, 0.0, 0.0))


def test_nothing_is_predicted_without_a_pose(predictor):
    assert predictor.predict(10.1) is None
    predictor.add_pose(10.1, START)
    predictor.clear_poses()
    assert predictor.predict(10.2) is None


def test_nothing_is_predicted_for_the_past(predictor):
    predictor.add_pose(10.1, START)
    assert predictor.predict(10.0) is None


def test_odometry_leads_on_from_the_last_pose(predictor):
    pose = SE2(-1.0, 0.5, 0.3)
    predictor.add_pose(10.0, pose)
    prior = predictor.predict(10.2)
    assert_same(prior.T_map_base, pose @ STEP)
    assert prior.radius == pytest.approx(SETTINGS.still_radius + SETTINGS.odometry_error * 0.1)
    assert prior.yaw_tolerance == pytest.approx(SETTINGS.still_turn + SETTINGS.odometry_error * 0.7)
    assert not prior.is_strict


def test_clearing_poses_keeps_odometry(predictor):
    predictor.clear_poses()
    assert_same(predictor.relative_motion(10.0, 10.2), STEP)


def test_without_odometry_a_steady_drive_goes_on():
    predictor = PosePredictor(SETTINGS)
    predictor.add_pose(1.0, START)
    predictor.add_pose(1.05, START @ SE2(0.02, 0.0, 0.0))
    prior = predictor.predict(1.1)
    assert_same(prior.T_map_base, START @ SE2(0.04, 0.0, 0.0))


def test_without_odometry_the_prior_covers_any_drive_within_the_acceleration():
    predictor = PosePredictor(SETTINGS)
    speed, dt = 0.4, 0.05
    for k in range(2):
        predictor.add_pose(k * dt, SE2(speed * k * dt, 0.0, 0.0))
    prior = predictor.predict(2 * dt)
    for acceleration in (-SETTINGS.acceleration_max, SETTINGS.acceleration_max):
        x = speed * 2 * dt + 0.5 * acceleration * dt * dt
        assert abs(prior.T_map_base.x - x) <= prior.radius
    assert 0.5 * SETTINGS.turn_acceleration_max * dt * dt <= prior.yaw_tolerance


def test_the_search_radius_grows_until_nothing_is_predicted():
    predictor = PosePredictor(SETTINGS)
    predictor.add_pose(0.0, START)
    radii = [predictor.predict(stamp).radius for stamp in (0.0, 0.05, 0.1, 0.2)]
    assert radii == sorted(radii)
    assert predictor.predict(5.0) is None


def test_heading_is_never_more_open_than_half_a_turn():
    predictor = PosePredictor(TrackerSettings(prior_radius_max=10.0))
    predictor.add_pose(0.0, START)
    assert predictor.predict(1.0).yaw_tolerance == math.pi
