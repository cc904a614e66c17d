"""Synchronizes messages of several topics by their stamps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, TypeVar

_WAITING_MAX = 10

Item = TypeVar('Item')


class StampGroups(Generic[Item]):
    """Groups one item of each topic with matching stamps, as message_filters' approximate time synchronizer.

    Attributes:
        completed: number of complete groups.
        dropped: number of items without a match.
    """

    def __init__(self, topics: Sequence[str], tolerance: float) -> None:
        """Start with empty queues.

        Args:
            topics: topics of a group.
            tolerance: largest difference between the stamps of a group [s].
        """
        self.formed = self.dropped = 0
        self._topics = tuple(topics)
        self._tolerance = tolerance
        self._waiting: dict[str, list[tuple[float, Item]]] = {topic: [] for topic in topics}

    def put(self, topic: str, stamp: float, item: Item) -> tuple[Item, ...] | None:
        """Add an item with its stamp [s]; return its group, in the order of the topics, once it is complete."""
        waiting = self._waiting[topic]
        waiting.append((stamp, item))
        if len(waiting) > _WAITING_MAX:
            waiting.pop(0)
            self.dropped += 1
        places = [self._place(other, stamp) for other in self._topics]
        if None in places:
            return None
        group = []
        for other, place in zip(self._topics, places, strict=True):
            assert place is not None  # noqa: S101 for the type checker
            group.append(self._waiting[other][place][1])
            self.dropped += place
            del self._waiting[other][: place + 1]
        self.formed += 1
        return tuple(group)

    @property
    def lacking(self) -> tuple[str, ...]:
        """Topics with an empty queue; none if all have items but their stamps differ."""
        return tuple(topic for topic in self._topics if not self._waiting[topic])

    def clear(self) -> None:
        """Clear the queues."""
        for waiting in self._waiting.values():
            waiting.clear()

    def _place(self, topic: str, stamp: float) -> int | None:
        for place, (other, _) in enumerate(self._waiting[topic]):
            if abs(other - stamp) <= self._tolerance:
                return place
        return None
