"""Velocity commands against kinematics from the textbook."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.robot.simulated_robot import MotorLimits, SimulatedRobot
from shirube_core.geometry import SE2

START = SE2(1.0, 2.0, 0.5 * math.pi)


def test_the_robot_is_stationary_until_the_first_command() -> None:
    robot = SimulatedRobot(START)
    assert robot.pose_at(-1.0) == robot.pose_at(0.0) == START
    robot.drive(0.0, 0.0, 3.0)
    assert robot.time == 3.0
    assert robot.pose_at(2.2).distance_to(START) == 0.0


def test_it_speeds_up_evenly_and_then_keeps_its_speed() -> None:
    robot = SimulatedRobot(START, MotorLimits(acceleration=0.5))
    robot.drive(0.4, 0.0, 2.0)
    for time in (0.3, 0.8):
        assert robot.pose_at(time).y - 2.0 == pytest.approx(0.25 * time**2, abs=2e-3)
    assert robot.pose_at(1.9).y - robot.pose_at(1.4).y == pytest.approx(0.2, abs=1e-9)
    assert robot.pose_at(1.9).x == pytest.approx(1.0)


def test_it_drives_circles() -> None:
    robot = SimulatedRobot(SE2(0.0, 0.0, 0.0), MotorLimits(1e6, 1e6))
    robot.drive(0.5, -0.25, math.tau / 0.25)
    half, whole = robot.pose_at(0.5 * robot.time), robot.pose_at(robot.time)
    assert (half.x, half.y) == pytest.approx((0.0, -4.0), abs=1e-9)
    assert whole.distance_to(SE2(0.0, 0.0, 0.0)) < 1e-9


def test_the_motion_has_no_steps_whatever_the_commands() -> None:
    robot, rng = SimulatedRobot(START), np.random.default_rng(0)
    while robot.time < 5.0:
        robot.drive(rng.uniform(-0.5, 0.5), rng.uniform(-2.0, 2.0), robot.time + rng.uniform(0.0, 0.2))
    poses = [robot.pose_at(float(time)) for time in np.arange(0.0, 5.0, 1e-3)]
    ways = np.array([a.distance_to(b) for a, b in zip(poses[:-1], poses[1:])])
    turns = np.array([a.yaw_to(b) for a, b in zip(poses[:-1], poses[1:])])
    assert ways.max() < 0.5e-3 + 1e-9
    assert np.abs(np.diff(turns)).max() < 3.0 * 0.005 * 1e-3 + 1e-9


def test_what_has_not_been_driven_is_not_known() -> None:
    robot = SimulatedRobot(START)
    robot.drive(0.2, 0.0, 1.0)
    with pytest.raises(SceneError, match='driven until'):
        robot.pose_at(1.1)
    with pytest.raises(SceneError, match='cannot drive'):
        robot.drive(0.2, 0.0, 0.9)
    with pytest.raises(SceneError, match='cannot drive'):
        robot.drive(float('nan'), 0.0, 2.0)
