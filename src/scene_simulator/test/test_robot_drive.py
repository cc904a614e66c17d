"""A drive keeps its route, its limits and its heading; its odometry is exact without errors and drifts with them."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.floor.demo_scene import ROUTE
from scene_simulator.robot.robot_drive import DriveLimits, RobotDrive, Waypoint, WheelErrors, simulate_odometry
from shirube_core.geometry import SE2

DRIVE = RobotDrive(ROUTE, DriveLimits())
TIMES = np.arange(0.0, 60.0, 0.01)
POSES = [DRIVE.pose_at(time) for time in TIMES]
PLACES = np.array([(pose.x, pose.y) for pose in POSES])
SPEEDS = np.hypot(*np.diff(PLACES, axis=0).T) / 0.01


def test_a_straight_drive_takes_the_time_of_its_ramps() -> None:
    drive = RobotDrive([Waypoint(0.0, 0.0, 0.5), Waypoint(2.0, 0.0, 0.5)], DriveLimits(acceleration=0.25))
    # 2 s and 0.5 m on each ramp, 1 m at 0.5 m/s between.
    assert drive.duration == pytest.approx(6.0, rel=0.01)
    assert drive.pose_at(3.0).x == pytest.approx(1.0, abs=1e-3)


def test_the_demo_drive_passes_its_waypoints_within_a_minute() -> None:
    assert 55.0 < DRIVE.duration < 60.0
    for waypoint in ROUTE:
        assert np.hypot(*(PLACES - (waypoint.x, waypoint.y)).T).min() < 0.005


@pytest.mark.parametrize('distance', [0.35, 0.7, 1.15, 1.4, 2.3])
def test_a_waypoint_may_be_within_rounding_of_a_planned_point(distance: float) -> None:
    for around in (distance, np.nextafter(distance, 0.0), np.nextafter(distance, 9.0)):
        points = [Waypoint(0.0, 0.0, 0.2, 30.0), Waypoint(around, 0.0, 0.2), Waypoint(3.0, 0.0, 0.2)]
        drive = RobotDrive(points, DriveLimits(acceleration=0.4))
        # 30 s of rest, 0.5 s and 0.05 m on each ramp, 2.9 m at 0.2 m/s between.
        assert drive.duration == pytest.approx(45.5, abs=0.05)


def test_the_robot_keeps_its_limits() -> None:
    assert 0.45 < SPEEDS.max() < 0.505
    assert np.abs(np.diff(SPEEDS)).max() / 0.01 < 0.6
    turns = np.diff(np.unwrap([pose.yaw for pose in POSES])) / 0.01
    assert np.abs(turns * SPEEDS).max() < 0.33


def test_the_robot_looks_where_it_goes() -> None:
    moving = SPEEDS > 0.05
    courses = np.arctan2(*np.diff(PLACES, axis=0).T[::-1])
    yaws = np.array([pose.yaw for pose in POSES[:-1]])
    difference = np.angle(np.exp(1j * (courses - yaws)))
    assert np.abs(difference[moving]).max() < 0.01


def test_the_robot_is_stationary_during_its_pause_and_at_the_end() -> None:
    standing = SPEEDS < 1e-6
    assert standing[:-200].sum() * 0.01 == pytest.approx(3.0, abs=0.1)
    assert DRIVE.pose_at(DRIVE.duration) == DRIVE.pose_at(1000.0)


def test_an_exposure_is_centred_on_its_middle() -> None:
    instants = DRIVE.poses_during(10.0, 0.002, 5)
    assert instants[2] == DRIVE.pose_at(10.0)
    assert instants[0].distance_to(instants[4]) == pytest.approx(0.8 * 0.002 * SPEEDS[1000], rel=0.01)


@pytest.mark.parametrize(
    ('route', 'complaint'),
    [
        ([Waypoint(0.0, 0.0, 1.0)], 'two points'),
        ([Waypoint(0.0, 0.0, 1.0), Waypoint(0.0, 0.0, 1.0)], 'twice'),
        ([Waypoint(0.0, 0.0, 0.0), Waypoint(1.0, 0.0, 1.0)], 'speed'),
        ([Waypoint(math.nan, 0.0, 0.5), Waypoint(1.0, 0.0, 1.0)], 'finite'),
    ],
)
def test_impossible_routes_are_refused(route: list[Waypoint], complaint: str) -> None:
    with pytest.raises(SceneError, match=complaint):
        RobotDrive(route)


STRAIGHT = [SE2(0.01 * step, 0.0, 0.0) for step in range(1001)]
PERFECT = WheelErrors(tick=1e-9, left_scale=1.0, right_scale=1.0, slip=0.0)


def test_a_reverse_arc_is_measured_too() -> None:
    step = SE2(-0.01, 0.0, 0.0) @ SE2(0.0, 0.0, 0.02)
    poses = [SE2(1.0, 1.0, 0.5)]
    for _ in range(50):
        poses.append(poses[-1] @ step)
    measured = simulate_odometry(poses, PERFECT, np.random.default_rng(1))[-1]
    assert measured.distance_to(poses[0].inverse() @ poses[-1]) < 0.01
    assert measured.yaw_to(poses[0].inverse() @ poses[-1]) == pytest.approx(0.0, abs=1e-6)


def test_the_default_wheels_drift_by_two_percent_and_a_degree_a_metre() -> None:
    runs = [simulate_odometry(STRAIGHT, WheelErrors(), np.random.default_rng(seed))[-1] for seed in range(20)]
    headings = np.array([run.yaw for run in runs])
    # The way along the arc: chord over sinc of half the turn.
    ways = [math.hypot(run.x, run.y) / np.sinc(run.yaw / 2.0 / math.pi) for run in runs]
    assert np.mean(ways) == pytest.approx(10.2, rel=0.002)
    assert math.degrees(headings.mean()) == pytest.approx(10.0, abs=1.0)
    expected_spread = WheelErrors().slip * math.sqrt(2.0 * 10.0) / WheelErrors().separation
    assert headings.std() == pytest.approx(expected_spread, rel=0.5)


def test_a_robot_at_rest_does_not_drift() -> None:
    odometry = simulate_odometry([POSES[200]] * 50, WheelErrors(), np.random.default_rng(1))
    assert set(odometry) == {SE2(0.0, 0.0, 0.0)}
