"""The robot of the closed-loop tests against kinematics from the textbook."""

import math

import pytest
from simulated_robot import MotorLimits, SimulatedRobot

from scene_simulator.errors import SceneError
from shirube_core.geometry import SE2

START = SE2(1.0, 2.0, 0.5 * math.pi)


def test_it_speeds_up_evenly_and_then_keeps_its_speed() -> None:
    robot = SimulatedRobot(START, MotorLimits(acceleration=0.5))
    robot.drive(0.4, 0.0, 2.0)
    assert robot.pose_at(-1.0) == START
    for time in (0.3, 0.8):
        assert robot.pose_at(time).y - 2.0 == pytest.approx(0.25 * time**2, abs=2e-3)
    assert robot.pose_at(1.9).y - robot.pose_at(1.4).y == pytest.approx(0.2, abs=1e-9)
    assert robot.pose_at(1.9).x == pytest.approx(1.0)
    with pytest.raises(SceneError, match='driven until'):
        robot.pose_at(2.1)


def test_it_drives_circles() -> None:
    robot = SimulatedRobot(SE2(0.0, 0.0, 0.0), MotorLimits(1e6, 1e6))
    robot.drive(0.5, -0.25, math.tau / 0.25)
    half, whole = robot.pose_at(0.5 * robot.time), robot.pose_at(robot.time)
    assert (half.x, half.y) == pytest.approx((0.0, -4.0), abs=1e-9)
    assert whole.distance_to(SE2(0.0, 0.0, 0.0)) < 1e-9
