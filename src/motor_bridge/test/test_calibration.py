import math

import numpy as np
import pytest

from motor_bridge.core.calibration import MeasuredRun, calibrate_wheels
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings

N = 1440


def straight(metres, radius=0.034):
    ticks = metres * N / (math.tau * radius)
    return MeasuredRun(ticks, ticks, metres)


def turn(radians, radius=0.034, separation=0.21):
    ticks = 0.5 * radians * separation * N / (math.tau * radius)
    return MeasuredRun(-ticks, ticks, radians)


def test_exact_runs_give_the_true_wheels():
    found = calibrate_wheels([straight(2.0), straight(-1.0)], [turn(30.0), turn(-12.0)], N)
    assert (found.radius, found.separation) == pytest.approx((0.034, 0.21))
    spreads = (found.radius_spread, found.separation_spread, found.wheel_asymmetry)
    assert spreads == pytest.approx((0, 0, 0), abs=1e-12)


def test_an_emulated_robot_is_measured():
    true = EmulatorSettings(wheel_radius=0.0351, wheel_separation=0.187, slip_sigma=0.001)
    robot = EmulatedController(true, np.random.default_rng(1))
    runs = []
    for command in (b'm 40 40\r', b'm -40 40\r'):
        before = np.array(robot.receive(b'e\r').split(), dtype=float)
        start, heading = robot.T_world_base, 0.0
        for request, seconds in [(command, 0.1)] * 80 + [(b'm 0 0\r', 1.0)]:
            last = robot.T_world_base
            robot.receive(request)
            robot.advance(robot.time + seconds)
            heading += last.yaw_to(robot.T_world_base)
        left, right = np.array(robot.receive(b'e\r').split(), dtype=float) - before
        runs.append(MeasuredRun(left, right, heading if runs else start.distance_to(robot.T_world_base)))
    found = calibrate_wheels(runs[:1], runs[1:], N)
    assert (found.radius, found.separation) == pytest.approx((0.0351, 0.187), rel=3e-3)


def test_spread_and_wheel_asymmetry_are_reported():
    crooked = MeasuredRun(10_300.0, 10_000.0, 2.0)
    found = calibrate_wheels([straight(2.0), straight(2.02, 0.0343), crooked], [turn(30.0)], N)
    assert found.radius_spread > 1e-4
    assert found.wheel_asymmetry == pytest.approx(0.01, abs=0.003)


@pytest.mark.parametrize(
    ('straights', 'turns', 'words'),
    [
        ([], [turn(30.0)], 'give at least one straight and one turn'),
        ([straight(2.0)], [], 'give at least one straight and one turn'),
        ([MeasuredRun(10, 10, 2.0)], [turn(30.0)], 'too short'),
        ([MeasuredRun(5000, 5000, 0.0)], [turn(30.0)], 'too short'),
        ([MeasuredRun(math.nan, 5000, 1.0)], [turn(30.0)], 'too short'),
        ([MeasuredRun(-5000, -5000, 2.0)], [turn(30.0)], 'the encoders counted backwards'),
        ([MeasuredRun(-100, 9000, 2.0)], [turn(30.0)], 'the wheels counted -100 and 9000 ticks'),
        ([straight(2.0)], [MeasuredRun(100, 9000, 30.0)], 'the wheels counted 100 and 9000 ticks'),
        ([MeasuredRun(1000, 1000, 50.0)], [turn(30.0)], 'wheel_radius is'),
        ([straight(2.0)], [MeasuredRun(-20000, 20000, 0.1)], 'wheel_separation is'),
    ],
)
def test_useless_runs_are_rejected_in_one_line(straights, turns, words):
    with pytest.raises(MotorBridgeError, match=words) as refusal:
        calibrate_wheels(straights, turns, N)
    assert '\n' not in str(refusal.value)
