import math

import pytest

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, Velocity
from motor_bridge.core.drive_settings import DriveSettings

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


def test_nothing_is_driven_before_somebody_wants_it():
    assert Driver().go(1.0) == (0, 0)


def test_a_velocity_becomes_its_wheels_speeds():
    left, right = Driver().go(3.0, Velocity(0.2, 0.5))
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
    assert not math.isclose(BASE.to_wheel_ticks(Velocity(0.0013, 0.0))[0], 0.0)
