"""Validates the stamps of messages, and groups messages of several topics by them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from std_msgs.msg import Header

from shirube_ros.errors import MessageError

_DELAY_MAX = 1.0  # a message older than this means that a bag or simulation restarted [s]
_QUEUE_MAX = 10  # items of a topic that wait for their group
_CLOCK_OFFSET_MAX = 1.0  # tolerated clock difference between hosts [s]

Item = TypeVar('Item')


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
        """Return the stamp of a message of a topic [s]; each topic is checked separately.

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


class StampSynchronizer(Generic[Item]):
    """Groups one item of each topic with matching stamps, as message_filters' approximate time synchronizer.

    It counts completed groups and items dropped without a match.
    """

    def __init__(self, topics: Sequence[str], tolerance: float) -> None:
        """Start with empty queues for a group of topics whose stamps differ by ``tolerance`` at most [s]."""
        self.completed = self.dropped = 0
        self._topics = tuple(topics)
        self._tolerance = tolerance
        self._queues: dict[str, list[tuple[float, Item]]] = {topic: [] for topic in topics}

    def put(self, topic: str, stamp: float, item: Item) -> tuple[Item, ...] | None:
        """Add an item with its stamp [s]; return its group, in the order of the topics, once it is complete."""
        queue = self._queues[topic]
        queue.append((stamp, item))
        if len(queue) > _QUEUE_MAX:
            queue.pop(0)
            self.dropped += 1
        indices = [self._find_match(other, stamp) for other in self._topics]
        if None in indices:
            return None
        group = []
        for other, index in zip(self._topics, indices, strict=True):
            assert index is not None  # noqa: S101 for the type checker
            group.append(self._queues[other][index][1])
            self.dropped += index
            del self._queues[other][: index + 1]
        self.completed += 1
        return tuple(group)

    @property
    def missing_topics(self) -> tuple[str, ...]:
        """Topics with an empty queue; none if all have items but their stamps differ."""
        return tuple(topic for topic in self._topics if not self._queues[topic])

    def clear(self) -> None:
        """Clear the queues."""
        for queue in self._queues.values():
            queue.clear()

    def _find_match(self, topic: str, stamp: float) -> int | None:
        stamps = [other for other, _ in self._queues[topic]]
        return next((i for i, other in enumerate(stamps) if abs(other - stamp) <= self._tolerance), None)
