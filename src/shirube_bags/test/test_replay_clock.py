"""Messages are due at their times, and a late replay does not catch up."""

import pytest

from shirube_bags.replay import ReplayClock

SECOND = 10**9


@pytest.mark.parametrize('rate', [0.5, 1.0, 4.0])
def test_messages_are_due_at_the_bag_s_time_over_the_rate(rate):
    pace = ReplayClock(rate, 100 * SECOND, now=7.0)
    assert pace.delay(100 * SECOND, 7.0) == 0.0
    assert pace.delay(102 * SECOND, 7.0) == pytest.approx(2.0 / rate)
    assert pace.delay(102 * SECOND, 7.0 + 1.5 / rate) == pytest.approx(0.5 / rate)


def test_the_bag_s_time_is_the_stamp_when_a_message_is_due():
    pace = ReplayClock(2.0, 100 * SECOND, now=7.0)
    assert pace.bag_time(7.0 + pace.delay(103 * SECOND, 7.0)) == 103 * SECOND


def test_rate_zero_never_waits():
    assert ReplayClock(0.0, 0, now=0.0).delay(10**15, 0.0) == 0.0


def test_after_a_halt_the_messages_keep_their_distances():
    pace = ReplayClock(1.0, 0, now=0.0)
    assert pace.delay(1 * SECOND, 5.0) == 0.0
    assert pace.delay(2 * SECOND, 5.0) == pytest.approx(1.0)
    assert pace.bag_time(5.0) == 1 * SECOND


def test_small_delays_do_not_add_up():
    pace = ReplayClock(1.0, 0, now=0.0)
    assert pace.delay(1 * SECOND, 1.01) == 0.0
    assert pace.delay(2 * SECOND, 1.01) == pytest.approx(0.99)
