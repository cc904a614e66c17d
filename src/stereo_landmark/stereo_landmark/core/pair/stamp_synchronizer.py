"""Synchronization of left and right images by their stamps."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

Item = TypeVar('Item')


class StampSynchronizer(Generic[Item]):
    """Pairs the items of two inputs by stamp; the stamps of each input must rise.

    Args:
        tolerance_ns: largest stamp difference of a pair [ns]; 0 for equal stamps. It must be less than half the frame
            interval.
        queue_size: largest number of unpaired items per input.
    """

    def __init__(self, tolerance_ns: int, queue_size: int) -> None:
        self._tolerance_ns = tolerance_ns
        self._queues: tuple[deque[tuple[int, Item]], ...] = (deque(), deque())
        self._queue_size = queue_size

    def add(self, side: int, stamp_ns: int, item: Item) -> tuple[Item, Item] | None:
        """Add an item and return the pair that it completes, None if it completes none.

        Args:
            side: 0 for left, 1 for right.
            stamp_ns: stamp of the item [ns].
            item: the item, such as an image.

        Raises:
            StereoLandmarkError: the queue is full, so the stamps of the inputs do not match.
        """
        own_queue, other_queue = self._queues[side], self._queues[1 - side]
        nearest = min(other_queue, key=lambda other: abs(other[0] - stamp_ns), default=None)
        if nearest is None or abs(nearest[0] - stamp_ns) > self._tolerance_ns:
            own_queue.append((stamp_ns, item))
            self._limit_queue(side)
            return None
        while other_queue and other_queue[0][0] <= nearest[0]:
            other_queue.popleft()
        own_queue.clear()
        return (item, nearest[1]) if side == 0 else (nearest[1], item)

    def _limit_queue(self, side: int) -> None:
        own_queue, other_queue = self._queues[side], self._queues[1 - side]
        if len(own_queue) <= self._queue_size:
            return
        own_queue.popleft()
        names = ('left', 'right')
        if not other_queue:
            raise StereoLandmarkError(
                f'{names[side]} images are received, but no {names[1 - side]} images; check that camera'
            )
        raise StereoLandmarkError(
            'left and right images have no stamps in common; trigger both cameras together, or set approximate_sync'
        )
