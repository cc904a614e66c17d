"""Stamps in order, late, and from a time that began again."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from shirube_ros.stamp_order import StampError, StampOrder


def header(stamp: float) -> Header:
    return Header(stamp=Time(sec=int(stamp), nanosec=round(stamp % 1.0 * 1e9)))


class Watched:
    def __init__(self) -> None:
        self.jumps = 0
        self.order = StampOrder(self._count)

    def _count(self) -> None:
        self.jumps += 1

    def take(self, topic: str, *stamps: float) -> None:
        for stamp in stamps:
            assert self.order.check(header(stamp), topic) == pytest.approx(stamp, abs=1e-6)


def test_stamps_may_grow_and_repeat_and_topics_are_independent() -> None:
    watched = Watched()
    watched.take('image', 10.0, 10.5, 10.5, 1e9)
    watched.take('odom', 5.0, 6.0)
    assert watched.jumps == 0


def test_a_straggler_is_refused_and_the_order_goes_on() -> None:
    watched = Watched()
    watched.take('image', 10.0, 10.5)
    with pytest.raises(StampError, match='image came out of order'):
        watched.order.check(header(10.4), 'image')
    watched.take('image', 10.5, 10.6)
    assert watched.jumps == 0


def test_a_jump_back_is_reported_once_and_starts_all_topics_again() -> None:
    watched = Watched()
    watched.take('image', 100.0)
    watched.take('odom', 100.0)
    watched.take('odom', 3.0)
    watched.take('image', 3.0, 3.1)
    watched.take('odom', 3.2)
    assert watched.jumps == 1
