"""Interpolation of odometry, and prediction of the pose."""

from __future__ import annotations

import math

import pytest

from floor_localizer.core.motion import Motion
from floor_localizer.core.settings import TrackerSettings
from shirube_geometry import PlanarPose

SETTINGS = TrackerSettings()
START = PlanarPose(5.0, -2.0, 2.8)
STEP = PlanarPose(0.1, 0.0, 0.6)


def assert_same(found, expected, tolerance=1e-9):
    assert found.distance_to(expected) < tolerance
    assert abs(found.turn_to(expected)) < tolerance


@pytest.fixture
def motion():
    motion = Motion(SETTINGS)
    motion.add_odometry(10.0, START)
    motion.add_odometry(10.2, START @ STEP)
    return motion


def test_at_a_message_it_is_the_message(motion):
    assert_same(motion.odometry_at(10.0), START)
    assert_same(motion.odometry_at(10.2), START @ STEP)


@pytest.mark.parametrize('share', [0.25, 0.5, 0.9])
def test_between_messages_the_step_is_shared_across_the_cut_at_pi(motion, share):
    found = motion.odometry_at(10.0 + 0.2 * share)
    assert_same(found, START @ PlanarPose(0.1 * share, 0.0, 0.6 * share), 1e-6)
    assert abs(START.turn_to(found)) == pytest.approx(0.6 * share)


def test_a_little_before_the_first_message_it_holds(motion):
    assert_same(motion.odometry_at(9.8), START)


@pytest.mark.parametrize('beyond', [0.5, 1.0])
def test_a_little_after_the_last_message_the_robot_goes_on(motion, beyond):
    found = motion.odometry_at(10.2 + 0.2 * beyond)
    assert_same(found, START @ STEP @ PlanarPose(0.1 * beyond, 0.0, 0.6 * beyond), 1e-6)


def test_after_a_gap_or_a_single_message_it_stays():
    motion = Motion(SETTINGS)
    motion.add_odometry(10.0, START)
    assert_same(motion.odometry_at(10.1), START)
    motion.add_odometry(11.0, START @ STEP)
    assert_same(motion.odometry_at(11.1), START @ STEP)


def test_stale_odometry_says_nothing(motion):
    assert motion.odometry_at(10.5) is None
    assert motion.odometry_at(9.7) is None
    assert motion.between(10.0, 10.5) is None
    assert Motion(SETTINGS).odometry_at(10.0) is None


def test_in_the_middle_of_a_long_gap_odometry_says_nothing(motion):
    motion.add_odometry(12.2, START)
    assert motion.odometry_at(11.2) is None


def test_an_older_message_is_left_out(motion):
    motion.add_odometry(10.1, PlanarPose(99.0, 0.0, 0.0))
    motion.add_odometry(10.2, PlanarPose(99.0, 0.0, 0.0))
    assert_same(motion.odometry_at(10.2), START @ STEP)


def test_between_forth_and_back_is_nothing(motion):
    there, back = motion.between(10.0, 10.2), motion.between(10.2, 10.0)
    assert_same(there, STEP)
    assert_same(there @ back, PlanarPose(0.0, 0.0, 0.0))


def test_nothing_is_expected_without_a_pose(motion):
    assert motion.expect(10.1) is None
    motion.add_pose(10.1, START)
    motion.forget_poses()
    assert motion.expect(10.2) is None


def test_nothing_is_expected_of_the_past(motion):
    motion.add_pose(10.1, START)
    assert motion.expect(10.0) is None


def test_odometry_leads_on_from_the_last_pose(motion):
    pose = PlanarPose(-1.0, 0.5, 0.3)
    motion.add_pose(10.0, pose)
    prior = motion.expect(10.2)
    assert_same(prior.T_map_base, pose @ STEP)
    assert prior.radius == pytest.approx(SETTINGS.still_radius + SETTINGS.odometry_error * 0.1)
    assert prior.turn == pytest.approx(SETTINGS.still_turn + SETTINGS.odometry_error * 0.7)
    assert not prior.must_hold


def test_forgetting_poses_keeps_odometry(motion):
    motion.forget_poses()
    assert_same(motion.between(10.0, 10.2), STEP)


def test_without_odometry_a_steady_drive_goes_on():
    motion = Motion(SETTINGS)
    motion.add_pose(1.0, START)
    motion.add_pose(1.05, START @ PlanarPose(0.02, 0.0, 0.0))
    prior = motion.expect(1.1)
    assert_same(prior.T_map_base, START @ PlanarPose(0.04, 0.0, 0.0))


def test_without_odometry_any_drive_within_the_acceleration_is_expected():
    motion = Motion(SETTINGS)
    speed, dt = 0.4, 0.05
    for k in range(2):
        motion.add_pose(k * dt, PlanarPose(speed * k * dt, 0.0, 0.0))
    prior = motion.expect(2 * dt)
    for acceleration in (-SETTINGS.acceleration_max, SETTINGS.acceleration_max):
        x = speed * 2 * dt + 0.5 * acceleration * dt * dt
        assert abs(prior.T_map_base.x - x) <= prior.radius
    assert 0.5 * SETTINGS.turn_acceleration_max * dt * dt <= prior.turn


def test_room_grows_with_time_until_nothing_is_expected():
    motion = Motion(SETTINGS)
    motion.add_pose(0.0, START)
    radii = [motion.expect(stamp).radius for stamp in (0.0, 0.05, 0.1, 0.2)]
    assert radii == sorted(radii)
    assert motion.expect(5.0) is None


def test_heading_is_never_more_open_than_half_a_turn():
    motion = Motion(TrackerSettings(prior_radius_max=10.0))
    motion.add_pose(0.0, START)
    assert motion.expect(1.0).turn == math.pi
