"""Wheel speed commands: timeout, emergency stop, limits, and rounding to ticks."""

import numpy as np
import pytest

from motor_bridge.core.base_drive import BaseDrive, TickAccumulator, clamp_ticks
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity

PERIOD = 1.0 / 30.0
SETTINGS = DriveSettings()
BASE = DiffDriveKinematics(SETTINGS)


class Driver:
    def __init__(self):
        self.drive, self.now, self.sent = BaseDrive(BASE, SETTINGS, PERIOD), 5.0, []

    def go(self, seconds, wanted=None):
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            if wanted is not None:
                self.drive.set_target(wanted, self.now)
            self.sent.append(self.drive.next_ticks(self.now))
        return self.sent[-1]


def test_a_velocity_becomes_its_wheels_speeds_and_nothing_is_driven_before():
    driver = Driver()
    assert driver.go(1.0) == (0, 0)
    left, right = driver.go(3.0, Velocity(0.2, 0.5))
    assert (left, right) == pytest.approx(BASE.to_wheel_ticks(Velocity(0.2, 0.5)), abs=1.0)


def test_silence_brakes_within_the_limits():
    driver = Driver()
    driver.go(3.0, Velocity(0.4, 0.0))
    full = driver.sent[-1][0]
    driver.go(0.5 - PERIOD)
    assert driver.sent[-1][0] == pytest.approx(full, abs=1.0)
    driver.go(1.2)
    assert driver.sent[-1] == (0, 0)
    steps = [abs(b[0] - a[0]) for a, b in zip(driver.sent, driver.sent[1:])]
    per_period = SETTINGS.max_linear_acceleration * PERIOD * SETTINGS.pid_frame / BASE.metres_per_tick
    assert max(steps) <= per_period * 1.2 + 1.0


def test_an_emergency_stops_at_once_and_drops_the_target():
    driver = Driver()
    driver.go(3.0, Velocity(0.4, 0.0))
    driver.drive.set_emergency_stop(is_on=True)
    assert driver.drive.next_ticks(driver.now) == (0, 0)
    assert driver.go(1.0, Velocity(0.4, 0.0)) == (0, 0)
    driver.drive.set_emergency_stop(is_on=False)
    assert driver.go(0.3) == (0, 0)
    assert driver.go(1.0, Velocity(0.4, 0.0))[0] > 0


def test_a_clock_that_goes_back_drives_nothing():
    driver = Driver()
    driver.go(1.0, Velocity(0.4, 0.0))
    driver.now -= 100.0
    assert driver.drive.is_timed_out(driver.now)
    assert driver.go(1.2) == (0, 0)


def test_slow_motion_comes_out_right_on_average():
    driver = Driver()
    driver.go(200.0, Velocity(0.0013, 0.0))
    ways = sum(left for left, _ in driver.sent) * PERIOD / SETTINGS.pid_frame * BASE.metres_per_tick
    assert ways == pytest.approx(0.26, rel=0.02)


FRAME = 0.033


@pytest.mark.parametrize('wanted', [0.04, 0.5, 3.7, -0.3, -12.01])
@pytest.mark.parametrize('period', [FRAME, 0.1])
def test_slow_motion_is_not_lost(wanted, period):
    rounding = TickAccumulator(FRAME, period)
    given = [rounding.next_ticks(wanted, period) for _ in range(2000)]
    way, wanted_way = sum(given) * period / FRAME, wanted * 2000 * period / FRAME
    assert abs(way - wanted_way) <= 1.5 * period / FRAME + 1e-6
    assert max(abs(g - wanted) for g in given) < 1.0


def test_irregular_calls_make_the_same_way():
    rng, rounding = np.random.default_rng(5), TickAccumulator(FRAME, FRAME)
    error, wanted, given = 0.0, 0.0, 0
    for step in range(5000):
        elapsed = float(rng.uniform(0.001, 0.05))
        error += (given - wanted) * elapsed / FRAME
        wanted = 5.3 + 4.0 * np.sin(0.01 * step)
        given = rounding.next_ticks(wanted, elapsed)
        assert abs(error) < 3.0


def test_a_stopped_wheel_does_not_turn_and_no_error_is_carried_over_a_reversal():
    rounding = TickAccumulator(FRAME, FRAME)
    for _ in range(7):
        rounding.next_ticks(0.4, FRAME)
    assert [rounding.next_ticks(0.0, FRAME) for _ in range(5)] == [0] * 5
    rounding = TickAccumulator(FRAME, FRAME)
    rounding.next_ticks(0.4, FRAME)
    assert rounding.next_ticks(-1.0, 100.0) == -1


@pytest.mark.parametrize('pair', [(40000.0, 20000.0), (-1e6, 3e5), (1e9, -1e9)])
def test_clamping_keeps_the_curvature_and_leaves_what_fits(pair):
    left, right = clamp_ticks(*pair)
    assert max(abs(left), abs(right)) == pytest.approx(32767.0)
    assert left * pair[1] == pytest.approx(right * pair[0])
    assert clamp_ticks(32767.0, -12.5) == (32767.0, -12.5)
