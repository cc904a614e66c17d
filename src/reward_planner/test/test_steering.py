"""Turns end without overshoot, and the robot can always stop in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.path_following import (
    braking_speed_limit,
    obstacle_speed_limit,
    turn_rate_for_angle,
    velocity_towards,
)
from reward_planner.core.driving.velocity_smoother import Velocity, VelocitySmoother

SETTINGS = DrivingSettings()


@pytest.mark.parametrize('angle', [3.1, -1.0, 0.2])
def test_a_turn_ends_without_overshoot(angle):
    ramp, left = VelocitySmoother(SETTINGS), angle
    for _ in range(400):
        left -= 0.02 * ramp.step_toward(Velocity(0.0, turn_rate_for_angle(left, SETTINGS)), 0.02).turn_rate
        assert left * angle > -1e-3
    assert abs(left) < 1e-2


def test_the_robot_stops_within_the_distance_from_the_speed_that_it_allows():
    for distance in np.linspace(0.0, 3.0, 31):
        ramp, left = VelocitySmoother(SETTINGS), distance
        for _ in range(1500):
            speed = min(braking_speed_limit(left, SETTINGS), SETTINGS.max_linear_velocity)
            left -= 0.02 * ramp.step_toward(Velocity(speed), 0.02).forward
        assert -0.02 < left < 0.05


def test_a_point_behind_is_turned_to_on_the_spot():
    for bearing in (1.5, -3.0):
        velocity = velocity_towards(bearing, 0.5, SETTINGS)
        assert velocity.forward == 0.0
        assert velocity.turn_rate * bearing > 0.0
    assert velocity_towards(0.0, 0.5, SETTINGS) == Velocity(0.5, 0.0)


def test_less_room_means_less_speed_but_never_none():
    speeds = [obstacle_speed_limit(gap, SETTINGS) for gap in np.linspace(-0.1, 1.0, 50)]
    assert (np.diff(speeds) >= 0.0).all()
    assert speeds[0] > 0.0
    assert speeds[-1] == SETTINGS.max_linear_velocity


def test_no_robot_is_fast_close_to_obstacles():
    fast = replace(SETTINGS, max_linear_velocity=3.0)
    assert obstacle_speed_limit(-0.1, fast) == pytest.approx(0.1)
    assert obstacle_speed_limit(fast.slow_distance, fast) == 3.0
