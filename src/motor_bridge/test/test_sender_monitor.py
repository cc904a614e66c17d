"""Senders of commands are distinguished though messages do not name them."""

import numpy as np
import pytest

from motor_bridge.command_inputs import MIXED_TIME, SenderMonitor
from motor_bridge.core.diff_drive_kinematics import Velocity


def is_mixed(commands):
    """Return whether rows of (time, number, forward) are noticed as mixed at their end, and ever."""
    monitor, ever = SenderMonitor(), False
    for time, number, forward in sorted(commands, key=lambda command: command[0]):
        monitor.take(number, Velocity(forward), time)
        ever |= monitor.is_mixed(time)
    return monitor.is_mixed(time), ever


def sender(rate, start, end, number, forward, numbered=True):
    times = np.arange(start, end, 1.0 / rate)
    return [(float(t), number + k if numbered else None, forward) for k, t in enumerate(times)]


@pytest.mark.parametrize('numbered', [True, False])
@pytest.mark.parametrize(('rate', 'number'), [(20.0, 1), (20.0, 1000), (7.0, 40), (2.0, 5), (1.5, 996)])
def test_two_senders_are_noticed_while_both_send(rate, number, numbered):
    one = sender(20.0, 0.013, 6.0, 1000, 0.3, numbered)
    other = sender(rate, 1.0, 4.0, number, -0.1, numbered)
    assert is_mixed(one + other) == (False, True)  # it ends after the other one
    assert is_mixed([c for c in one + other if c[0] < 3.9])[0]


@pytest.mark.parametrize(
    'commands',
    [
        sender(20.0, 0.0, 3.0, 1, 0.3),
        [c for c in sender(20.0, 0.0, 3.0, 1, 0.3) if not 1.0 < c[0] < 1.8],  # messages are lost
        sender(20.0, 0.0, 1.0, 1000, 0.3) + sender(20.0, 1.02, 3.0, 1, 0.2),  # one after the other
        [(0.05 * k, k, 0.3 * (-1) ** k) for k in range(60)],  # numbers show one sender that is not smooth
        [(0.1 * k, None, 0.05 * min(k, 10)) for k in range(60)],  # a smooth one without numbers
        [*sender(20.0, 0.0, 2.0, 1, 0.3), (-5.0, 500, 0.1)],
    ],
)
def test_one_sender_at_a_time_is_not_mixed(commands):
    assert is_mixed(commands) == (False, False)


def test_mixed_commands_are_forgotten_when_the_clock_jumps_back():
    monitor = SenderMonitor()
    for number in (100, 5, 101):
        monitor.take(number, Velocity(), 10.0)
    assert monitor.is_mixed(10.0 + MIXED_TIME)
    assert not monitor.is_mixed(10.0 + 1.01 * MIXED_TIME)
    assert not monitor.is_mixed(9.0)
