"""Priorities of topics, and senders that are told apart though messages do not name them."""

import numpy as np
import pytest

from motor_bridge.core.command_arbitration import (
    MIXED_TIME,
    CommandMux,
    CommandTopic,
    SenderMonitor,
    parse_mux_topics,
)
from motor_bridge.core.diff_drive_kinematics import Velocity
from motor_bridge.core.motor_bridge_error import MotorBridgeError


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


def test_a_topic_drives_unless_one_of_higher_priority_is_alive():
    mux = CommandMux(parse_mux_topics(' nav_vel 1 0.5 , /joy/vel 10 0.2,~/auto 5 1'))
    taken = [
        ('nav_vel', 0.0, True),
        ('/joy/vel', 0.1, True),
        ('nav_vel', 0.29, False),
        ('~/auto', 0.3, False),
        ('~/auto', 0.31, True),
        ('nav_vel', 1.2, False),
        ('nav_vel', 1.32, True),
        ('nav_vel', -5.0, True),
    ]
    assert [mux.take(name, now) for name, now, _ in taken] == [is_taken for *_, is_taken in taken]
    assert parse_mux_topics('') == []
    assert parse_mux_topics('a 1 2') == [CommandTopic('a', 1.0, 2.0)]


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        *(
            (t, 'mux_topics has .*; write topic')
            for t in ('a', 'a 1', 'a 1 2 3', 'a x 1', 'a nan 1', 'a 1 0')
        ),
        *((t, 'mux_topics has .*; write topic') for t in ('a 1 inf', '9a 1 1', 'a/ 1 1', 'a! 1 1')),
        *((t, 'a topic or a priority twice') for t in ('a 1 1, a 2 1', 'a 1 1, b 1 1')),
    ],
)
def test_other_texts_are_refused_in_one_line(text, words):
    with pytest.raises(MotorBridgeError, match=words) as refusal:
        parse_mux_topics(text)
    assert '\n' not in str(refusal.value)
