"""Velocities change within the limits and arrive."""

import numpy as np
import pytest

from reward_planner.core.driving.drive_state import Velocity, VelocitySmoother
from reward_planner.core.settings import DrivingSettings

SETTINGS = DrivingSettings(max_linear_jerk=2.0)
STEP = 0.02


def speeds(ramp, wanted, seconds=4.0):
    return np.array([ramp.step_toward(wanted, STEP).forward for _ in range(round(seconds / STEP))])


def test_speed_acceleration_and_jerk_stay_within_limits():
    ramp = VelocitySmoother(SETTINGS)
    way = np.concatenate([speeds(ramp, Velocity(wanted)) for wanted in (9.0, -0.2, 0.0)])
    accelerations = np.diff(way, prepend=0.0) / STEP
    assert way.max() == pytest.approx(SETTINGS.max_linear_velocity)
    assert np.abs(accelerations).max() <= SETTINGS.max_linear_acceleration + 1e-9
    jerks = np.diff(accelerations, prepend=0.0) / STEP
    assert np.percentile(np.abs(jerks), 95) <= SETTINGS.max_linear_jerk + 1e-6
    assert way[-1] == 0.0


def test_turn_rates_arrive_within_limits():
    ramp = VelocitySmoother(SETTINGS)
    rates = [ramp.step_toward(Velocity(0.0, -9.0), STEP).turn_rate for _ in range(100)]
    assert min(rates) == rates[-1] == pytest.approx(-SETTINGS.max_angular_velocity)
    assert np.abs(np.diff(rates)).max() <= SETTINGS.max_angular_acceleration * STEP + 1e-9


@pytest.mark.parametrize('seconds', [0.3, 0.8, 4.0])
def test_the_robot_stops_within_the_braking_distance(seconds):
    ramp = VelocitySmoother(SETTINGS)
    speeds(ramp, Velocity(9.0), seconds)
    told = ramp.braking_distance()
    driven = speeds(ramp, Velocity()).sum() * STEP
    assert 0.3 * told < driven < told + 0.01


def test_a_long_pause_is_no_licence_for_a_leap():
    ramp = VelocitySmoother(SETTINGS)
    assert ramp.step_toward(Velocity(1.0), 60.0).forward <= 0.2 * SETTINGS.max_linear_acceleration
    assert ramp.step_toward(Velocity(1.0), -5.0).forward <= 0.2 * SETTINGS.max_linear_acceleration
