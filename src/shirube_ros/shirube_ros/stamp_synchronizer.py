"""Synchronizes messages of several topics by their stamps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, TypeVar

_QUEUE_MAX = 10

Item = TypeVar('Item')


class StampSynchronizer(Generic[Item]):
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
        for index, (other, _) in enumerate(self._queues[topic]):
            if abs(other - stamp) <= self._tolerance:
                return index
        return None
