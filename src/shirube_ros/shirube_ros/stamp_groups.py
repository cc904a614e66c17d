"""Brings together what belongs together: messages of several topics with the same stamp."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, TypeVar

_WAITING_MAX = 10

Item = TypeVar('Item')


class StampGroups(Generic[Item]):
    """Gathers one item of each topic.

    Attributes:
        formed: groups that became whole.
        dropped: items whose partners did not come.
    """

    def __init__(self, topics: Sequence[str], tolerance: float) -> None:
        """Begin with nothing.

        Args:
            topics: whose items make a group.
            tolerance: stamps of a group differ by no more [s].
        """
        self.formed = self.dropped = 0
        self._topics = tuple(topics)
        self._tolerance = tolerance
        self._waiting: dict[str, list[tuple[float, Item]]] = {topic: [] for topic in topics}

    def put(self, topic: str, stamp: float, item: Item) -> tuple[Item, ...] | None:
        """Take an item with its stamp [s]; return its group, in the order of the topics, once it is whole."""
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
        """The topics of which nothing waits; none where all wait but their stamps differ."""
        return tuple(topic for topic in self._topics if not self._waiting[topic])

    def clear(self) -> None:
        """Forget what waits."""
        for waiting in self._waiting.values():
            waiting.clear()

    def _place(self, topic: str, stamp: float) -> int | None:
        for place, (other, _) in enumerate(self._waiting[topic]):
            if abs(other - stamp) <= self._tolerance:
                return place
        return None
