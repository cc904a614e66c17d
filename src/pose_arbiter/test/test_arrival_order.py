"""Late and out-of-order messages do not change the result."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from short_drive import (
    BEGIN,
    ODOMETRY,
    SECOND,
    add_messages,
    messages,
    new_arbiter,
    noisy,
    numbers,
    shift_pose,
    true_pose,
)

from pose_arbiter.core.settings import SourceSettings
from shirube_core.geometry import SE2


def faulty(seconds):
    return shift_pose(true_pose(seconds), 0.3) if seconds > 0.8 else true_pose(seconds)


SAID = messages(2.0, [noisy(1), noisy(2), faulty])
NOW = SAID[-1][0]


def outcome(said, now=NOW, at=NOW):
    arbiter = new_arbiter(3, history_seconds=10.0)
    add_messages(arbiter, said, now)
    return numbers(arbiter.estimate_at(at)), arbiter.counts()


@given(st.randoms(use_true_random=False))
@settings(max_examples=15, deadline=None)
def test_any_order_gives_the_same(rng):
    shuffled = SAID[:]
    rng.shuffle(shuffled)
    expected, result = outcome(SAID), outcome(shuffled)
    assert result[0] == pytest.approx(expected[0], abs=1e-9)
    assert result[1] == expected[1]


@pytest.mark.newest_set_only
def test_asking_in_between_does_not_change_what_comes_out():
    arbiter = new_arbiter(3, history_seconds=10.0)
    shuffled = SAID[:]
    random.Random(5).shuffle(shuffled)
    for message in shuffled:
        add_messages(arbiter, [message], NOW)
        arbiter.estimate_at(NOW)
    assert numbers(arbiter.estimate_at(NOW)) == pytest.approx(outcome(SAID)[0], abs=1e-9)


def test_late_by_less_than_the_history_is_as_in_time():
    late = sorted(SAID, key=lambda m: m[0] + (0 if m[1] == ODOMETRY else 150_000_000 * (m[1] + 1)))
    arbiter = new_arbiter(3, history_seconds=1.0)
    newest = 0
    for message in late:
        newest = max(newest, message[0])
        add_messages(arbiter, [message], newest)
    assert numbers(arbiter.estimate_at(NOW)) == pytest.approx(outcome(SAID)[0], abs=1e-9)


def test_sources_with_equal_stamps_have_no_order():
    said = [m for m in messages(1.0, [noisy(1)]) if m[1] == ODOMETRY]
    for k in range(1, 20):
        at = 0.05 * k
        said += [(BEGIN + round(at * SECOND), n, shift_pose(true_pose(at), 0.001 * n)) for n in (2, 0, 1)]
    ascending = sorted(said, key=lambda m: (m[0], str(m[1])))
    descending = sorted(said, key=lambda m: (m[0], str(m[1])), reverse=True)
    end = BEGIN + SECOND
    assert outcome(ascending, end, end) == outcome(descending, end, end)


def test_the_past_stays_what_it_was_seen_from():
    arbiter, long_history = new_arbiter(3, history_seconds=0.3), new_arbiter(3, history_seconds=30.0)
    for message in SAID:
        add_messages(arbiter, [message])
        add_messages(long_history, [message])
    assert len(arbiter._measurements) < 30
    expected = numbers(long_history.estimate_at(NOW))
    assert numbers(arbiter.estimate_at(NOW)) == pytest.approx(expected, abs=1e-9)
    assert arbiter.counts() == long_history.counts()


def test_an_offset_is_taken_off():
    mount = SE2(0.2, -0.1, 0.3)
    plain = new_arbiter(1)
    add_messages(plain, messages(1.0, [true_pose]))
    source = SourceSettings(sigma_xy=0.005, sigma_yaw=0.005, offset=(mount.x, mount.y, mount.yaw))
    moved = new_arbiter(1, [source])
    add_messages(moved, messages(1.0, [lambda s: true_pose(s) @ mount.inverse()]))
    end = BEGIN + SECOND
    assert numbers(moved.estimate_at(end)) == pytest.approx(numbers(plain.estimate_at(end)), abs=1e-9)
