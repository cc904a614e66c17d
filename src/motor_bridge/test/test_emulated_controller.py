"""The emulated controller replies and drives as the real one does."""

import math

import numpy as np
import pytest

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from shirube_core.geometry import SE2

EXACT = EmulatorSettings(encoder_noise=0.0, slip_sigma=0.0)
ORIGIN = SE2(0.0, 0.0, 0.0)
TICK = math.tau / EXACT.ticks_per_revolution


def a_controller(settings=EXACT, start=ORIGIN, speeds=None):
    controller = EmulatedController(settings, np.random.default_rng(7), start)
    if speeds:
        controller.receive(b'm %d %d\r' % speeds)
    return controller


def counts(controller):
    return tuple(map(int, controller.receive(b'e\r').split()))


@pytest.mark.parametrize(
    ('sent', 'replies'),
    [
        (b'b\r', b'57600\r\n'),
        (b'e\r', b'0 0\r\n'),
        *[(sent, b'OK\r\n') for sent in (b'r\r', b'm 10 -10\r', b'o 100 -100\r', b'u 20:12:0:50\r')],
        *[(sent, b'Invalid Command\r\n') for sent in (b'\r', b'?\r', b'b\n\r')],
        *[(sent, b'') for sent in (b'b\n', b'e')],
        (b'b\rb\r', b'57600\r\n57600\r\n'),
    ],
)
def test_commands_are_answered(sent, replies):
    assert a_controller().receive(sent) == replies


def test_a_speed_is_held_nine_percent_low_until_the_auto_stop():
    controller = a_controller(speeds=(60, 60))
    controller.advance(1.0)
    assert controller.wheel_speeds == pytest.approx((0.91 * 60 * TICK / 0.033,) * 2, rel=0.015)
    controller.advance(1.99)
    assert not controller.is_stopped
    controller.advance(2.8)
    assert controller.is_stopped


@pytest.mark.parametrize('slip', [0.0, 0.1])
def test_what_the_encoders_count_is_how_far_the_wheels_went_without_slip(slip):
    settings = EmulatorSettings(encoder_noise=0.0, slip_sigma=0.0, slip=slip)
    controller = a_controller(settings, SE2(1.0, 2.0, math.pi / 2), (50, 50))
    controller.advance(4.0)
    left, right = counts(controller)
    assert left == right > 1000
    pose, distance = controller.T_world_base, (1.0 - slip) * left * TICK * EXACT.wheel_radius
    assert (pose.x, pose.y) == pytest.approx((1.0, 2.0 + distance), abs=1e-4)


def test_wheels_against_each_other_turn_on_the_spot():
    controller = a_controller(speeds=(-30, 30))
    controller.advance(1.0)
    pose = controller.T_world_base
    left, right = counts(controller)
    turn = (right - left) * TICK * EXACT.wheel_radius / EXACT.wheel_separation
    assert turn > 0.5
    assert (pose.x, pose.y) == pytest.approx((0.0, 0.0), abs=7e-4)
    assert pose.yaw == pytest.approx(turn, abs=0.01)


def test_a_lost_end_of_a_command_lets_a_wheel_run_away_and_a_leading_one_cures_it():
    wild, cured = a_controller(), a_controller()
    wild.receive(b'm 1')
    wild.receive(b'm 10 10\r')
    cured.receive(b'm 1')
    cured.receive(b'\rm 10 10\r')
    for controller in (wild, cured):
        controller.advance(1.0)
    assert wild.wheel_speeds[1] == pytest.approx(EXACT.wheel_speed_max, rel=0.01)
    assert max(cured.wheel_speeds) < 3.0


def test_too_large_an_argument_is_full_reverse():
    controller = a_controller(speeds=(32768, 32768))
    controller.advance(0.5)
    assert max(controller.wheel_speeds) < -20.0


def test_a_reset_stops_the_motors_and_zeroes_the_counts():
    controller = a_controller(speeds=(50, 50))
    controller.advance(1.0)
    controller.reset()
    assert controller.receive(b'e\r') == b''
    controller.advance(2.6)
    assert controller.is_stopped
    assert 0 < counts(controller)[0] < 300  # it coasted


def test_the_past_is_remembered_and_the_future_is_refused():
    controller, past = a_controller(speeds=(50, 20)), []
    for step in range(1, 11):
        controller.advance(0.1 * step)
        past.append((controller.time, controller.T_world_base))
    for time, pose in past:
        seen = controller.pose_at(time)
        assert (seen.x, seen.y, seen.yaw) == pytest.approx((pose.x, pose.y, pose.yaw))
    between = controller.pose_at(0.5 * (past[-1][0] + controller._times[-2])).x
    assert controller._poses[-2].x < between < past[-1][1].x
    assert controller.pose_at(-1.0) == SE2(0.0, 0.0, 0.0)
    with pytest.raises(MotorBridgeError, match='is simulated until 1'):
        controller.pose_at(1.5)


def test_how_often_time_is_let_pass_changes_little():
    poses = []
    for steps in (10, 400):
        controller = a_controller(speeds=(50, 30))
        for step in range(1, steps + 1):
            controller.advance(2.0 * step / steps)
        poses.append(controller.T_world_base)
    assert poses[0].distance_to(poses[1]) < 2e-3


def test_counts_wrap_at_32_bits():
    controller = a_controller()
    for ticks, count in ((2**31 - 5, 2**31 - 5), (2**31 + 5, -(2**31) + 5)):
        controller._body.wheel_angles = (ticks * TICK, 0.0)
        assert counts(controller) == (count, 0)


def test_gains_are_taken_over():
    loose, firm = a_controller(), a_controller()
    loose.receive(b'u 0:0:0:50\r')
    for controller in (loose, firm):
        controller.receive(b'm 50 50\r')
        controller.advance(1.0)
    assert loose.is_stopped
    assert not firm.is_stopped
