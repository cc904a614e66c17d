"""Validates the stamps of messages: out-of-order messages are rejected, a jump back in time is reported."""

from __future__ import annotations

from collections.abc import Callable

from std_msgs.msg import Header

from shirube_ros.message_error import MessageError

_DELAY_MAX = 1.0  # a message older than this means that a bag or simulation restarted [s]
_CLOCK_OFFSET_MAX = 1.0  # tolerated clock difference between hosts [s]


class StampError(MessageError):
    """A message is older than its predecessor, or its stamp is zero or in the future."""


class StampValidator:
    """Checks that stamps do not decrease within a topic."""

    def __init__(self, on_jump_back: Callable[[], None], now: Callable[[], float] | None = None) -> None:
        """Start without stamps.

        Args:
            on_jump_back: called when a stamp is more than a second older than its predecessor.
            now: returns the current time [s], 0 before simulated time has started. If given, stamps that are zero or
                in the future are rejected, so that they are not mistaken for a jump back.
        """
        self._on_jump_back, self._now = on_jump_back, now
        self._latest: dict[str, float] = {}

    def check(self, header: Header, topic: str) -> float:
        """Return the stamp of a message [s].

        Args:
            header: header of the message.
            topic: topic of the message; each topic is checked separately.

        Raises:
            StampError: the message is out of order, or its stamp is zero or in the future.
        """
        stamp = float(header.stamp.sec + header.stamp.nanosec * 1e-9)
        self._check_clock(stamp, topic)
        age = self._latest.get(topic, stamp) - stamp
        if age > _DELAY_MAX:
            self._latest.clear()
            self._on_jump_back()
        elif age > 0.0:
            raise StampError(f'{topic} came out of order; check the network and the stamps of its publisher')
        self._latest[topic] = stamp
        return stamp

    def _check_clock(self, stamp: float, topic: str) -> None:
        now = 0.0 if self._now is None else self._now()
        if now <= 0.0:
            return
        if stamp == 0.0:
            raise StampError(f'{topic} has a stamp of 0; let its publisher set header.stamp')
        if stamp > now + _CLOCK_OFFSET_MAX:
            raise StampError(
                f'{topic} has a stamp in the future; synchronize the clocks, and set use_sim_time of all nodes alike'
            )
