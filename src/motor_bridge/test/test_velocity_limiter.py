"""Speed, acceleration and jerk stay within their limits for any target, and curvature is kept."""

import math

import numpy as np
import pytest

from motor_bridge.core.base_drive import STEP, VelocityLimiter
from motor_bridge.core.diff_drive_kinematics import DriveSettings, Velocity

SETTINGS = DriveSettings()
LIMITS = (
    np.array([SETTINGS.max_linear_velocity, SETTINGS.max_angular_velocity]),
    np.array([SETTINGS.max_linear_acceleration, SETTINGS.max_angular_acceleration]),
    SETTINGS.max_linear_jerk * np.array([1.0, SETTINGS.max_angular_acceleration / SETTINGS.max_linear_acceleration]),
)


def driven(limiter, wanted, steps, elapsed=STEP):
    velocities = [limiter.step_toward(wanted, elapsed) for _ in range(steps)]
    return np.array([(v.forward, v.turn_rate) for v in velocities])


def assert_within_limits(velocities):
    speed, acceleration, jerk = LIMITS
    rows = np.vstack([np.zeros((2, 2)), velocities])
    assert (np.abs(rows) <= speed * (1.0 + 1e-9)).all()
    rates = np.diff(rows, axis=0) / STEP
    assert (np.abs(rates) <= acceleration * (1.0 + 1e-6)).all()
    assert (np.abs(np.diff(rates, axis=0)) / STEP <= jerk * (1.0 + 1e-6)).all()


@pytest.mark.parametrize('wanted', [(0.5, 0.0), (0.3, 0.5), (0.2, -1.4), (-0.4, 0.1), (0.0, 1.5), (3.0, 2.0)])
def test_the_curvature_is_kept_from_rest_to_speed_and_down_to_rest(wanted):
    limiter = VelocityLimiter(SETTINGS)
    up = driven(limiter, Velocity(*wanted), 600)
    down = driven(limiter, Velocity(), 600)
    for velocity in np.vstack([up, down]):
        assert velocity[0] * wanted[1] == pytest.approx(velocity[1] * wanted[0], abs=1e-9)
    factor = max(1.0, abs(wanted[0]) / 0.5, abs(wanted[1]) / 1.5)
    np.testing.assert_allclose(up[-1], np.array(wanted) / factor, atol=1e-12)
    assert (down[-1] == 0.0).all()
    assert (np.diff(np.abs(up), axis=0) >= -1e-12).all()  # no overshoot
    assert_within_limits(np.vstack([up, down]))


@pytest.mark.parametrize('seed', range(8))
def test_limits_hold_whatever_is_wanted(seed):
    rng = np.random.default_rng(seed)
    limiter = VelocityLimiter(SETTINGS)
    wanted = [Velocity(*rng.normal(0.0, (0.5, 2.0))) for _ in range(80)]
    rows = [driven(limiter, each, int(rng.integers(1, 120))) for each in wanted]
    assert_within_limits(np.vstack(rows))


@pytest.mark.parametrize('seed', range(4))
def test_backwards_is_as_forwards(seed):
    rng, forwards = np.random.default_rng(seed), VelocityLimiter(SETTINGS)
    backwards = VelocityLimiter(SETTINGS)
    for _ in range(40):
        forward, turn_rate, count = *rng.uniform((-1.0, -3.0), (1.0, 3.0)), int(rng.integers(1, 60))
        there = driven(forwards, Velocity(forward, turn_rate), count)
        back = driven(backwards, Velocity(-forward, -turn_rate), count)
        np.testing.assert_allclose(back, -there, atol=1e-12)


def test_speed_is_reached_in_the_least_time_that_the_limits_allow():
    limiter = VelocityLimiter(SETTINGS)
    velocities = driven(limiter, Velocity(0.5, 0.0), 1000)
    v, a, j = 0.5, SETTINGS.max_linear_acceleration, SETTINGS.max_linear_jerk
    least = v / a + a / j
    first = np.argmax(velocities[:, 0] >= 0.5 - 1e-9) * STEP
    assert least - 3 * STEP <= first <= least + 5 * STEP


def test_how_often_it_is_called_changes_nothing():
    often, seldom = VelocityLimiter(SETTINGS), VelocityLimiter(SETTINGS)
    for _ in range(30):
        driven(often, Velocity(0.4, 1.0), 8)
        driven(seldom, Velocity(0.4, 1.0), 1, 8 * STEP)
        assert math.isclose(often.velocity.forward, seldom.velocity.forward, rel_tol=1e-9)
    often.halt()
    assert often.velocity == often.step_toward(Velocity(), 0.1) == Velocity()
