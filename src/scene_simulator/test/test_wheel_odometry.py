"""Odometry without errors is exact; with errors it drifts as configured."""

import math

import numpy as np
import pytest

from scene_simulator.floor.demo_scene import ROUTE
from scene_simulator.robot.robot_drive import RobotDrive
from scene_simulator.robot.wheel_odometry import WheelErrors, simulate_odometry
from shirube_core.geometry import SE2

DRIVE = RobotDrive(ROUTE)
DRIVEN = [DRIVE.pose_at(time) for time in np.arange(0.0, 60.0, 0.02)]
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
    odometry = simulate_odometry([DRIVEN[100]] * 50, WheelErrors(), np.random.default_rng(1))
    assert set(odometry) == {SE2(0.0, 0.0, 0.0)}
