"""Watches the stamps of messages: late ones are refused, a jump back in time is a new beginning."""

from __future__ import annotations

from collections.abc import Callable

from std_msgs.msg import Header

from shirube_ros.message_error import MessageError

_LONGEST_DELAY = 1.0  # an older message is no straggler: a bag or a simulation began again [s]


class StampError(MessageError):
    """A message is older than its predecessor."""


class StampOrder:
    """Hands on stamps that do not decrease within a topic."""

    def __init__(self, on_jump_back: Callable[[], None]) -> None:
        """Start without a past.

        Args:
            on_jump_back: called when a stamp is more than a second older than its predecessor.
        """
        self._on_jump_back = on_jump_back
        self._latest: dict[str, float] = {}

    def check(self, header: Header, topic: str) -> float:
        """Return the stamp of a message [s].

        Args:
            header: header of the message.
            topic: name of its topic; each topic has its own order.

        Raises:
            StampError: the message came too late.
        """
        stamp = header.stamp.sec + header.stamp.nanosec * 1e-9
        age = self._latest.get(topic, stamp) - stamp
        if age > _LONGEST_DELAY:
            self._latest.clear()
            self._on_jump_back()
        elif age > 0.0:
            raise StampError(f'{topic} came out of order; check the network and the stamps of its publisher')
        self._latest[topic] = stamp
        return stamp
