"""Watches the stamps of messages: late ones are refused, a jump back in time is a new beginning."""

from __future__ import annotations

from collections.abc import Callable

from std_msgs.msg import Header

from shirube_ros.message_error import MessageError

_LONGEST_DELAY = 1.0  # an older message is no straggler: a bag or a simulation began again [s]
_AHEAD_MAX = 1.0  # clocks that are set alike differ by no more [s]


class StampError(MessageError):
    """A message is older than its predecessor, or its stamp is no time of now."""


class StampOrder:
    """Hands on stamps that do not decrease within a topic."""

    def __init__(self, on_jump_back: Callable[[], None], now: Callable[[], float] | None = None) -> None:
        """Start without a past.

        Args:
            on_jump_back: called when a stamp is more than a second older than its predecessor.
            now: the time [s], 0 while simulated time has not begun. A node that compares stamps with it gives it, so
                that stamps that are not set or lie in the future are refused and do not look like a jump back.
        """
        self._on_jump_back, self._now = on_jump_back, now
        self._latest: dict[str, float] = {}

    def check(self, header: Header, topic: str) -> float:
        """Return the stamp of a message [s].

        Args:
            header: header of the message.
            topic: name of its topic; each topic has its own order.

        Raises:
            StampError: the message came too late, or its stamp is no time of now.
        """
        stamp = float(header.stamp.sec + header.stamp.nanosec * 1e-9)
        self._compare_with_now(stamp, topic)
        age = self._latest.get(topic, stamp) - stamp
        if age > _LONGEST_DELAY:
            self._latest.clear()
            self._on_jump_back()
        elif age > 0.0:
            raise StampError(f'{topic} came out of order; check the network and the stamps of its publisher')
        self._latest[topic] = stamp
        return stamp

    def _compare_with_now(self, stamp: float, topic: str) -> None:
        now = 0.0 if self._now is None else self._now()
        if now <= 0.0:
            return
        if stamp == 0.0:
            raise StampError(f'{topic} has a stamp of 0; let its publisher set it')
        if stamp > now + _AHEAD_MAX:
            raise StampError(
                f'{topic} has a stamp in the future; set all clocks, and use_sim_time of all nodes, alike'
            )
