"""Which left image belongs to which right one, by their stamps."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

Item = TypeVar('Item')


class StampPairing(Generic[Item]):
    """Pairs what comes on two sides, each in the order of its stamps.

    Args:
        tolerance_ns: stamps of a pair differ by no more; 0 for exactly the same [ns]. It must be less than half the
            time between two images.
        queue_size: of each side so many wait for their partner.
    """

    def __init__(self, tolerance_ns: int, queue_size: int) -> None:
        self._tolerance_ns = tolerance_ns
        self._queues: tuple[deque[tuple[int, Item]], ...] = (deque(), deque())
        self._queue_size = queue_size

    def add(self, side: int, stamp_ns: int, item: Item) -> tuple[Item, Item] | None:
        """Take an item and return the pair that it completes, None if it does not.

        Args:
            side: 0 for left, 1 for right.
            stamp_ns: when it was taken [ns].
            item: whatever belongs to it.

        Raises:
            StereoLandmarkError: so many items have waited in vain that the sides have no time in common.
        """
        mine, others = self._queues[side], self._queues[1 - side]
        near = min(others, key=lambda other: abs(other[0] - stamp_ns), default=None)
        if near is None or abs(near[0] - stamp_ns) > self._tolerance_ns:
            mine.append((stamp_ns, item))
            self._drop_if_full(side)
            return None
        while others and others[0][0] <= near[0]:
            others.popleft()
        mine.clear()
        return (item, near[1]) if side == 0 else (near[1], item)

    def clear(self) -> None:
        """Forget what waits."""
        for queue in self._queues:
            queue.clear()

    def _drop_if_full(self, side: int) -> None:
        mine, others = self._queues[side], self._queues[1 - side]
        if len(mine) <= self._queue_size:
            return
        mine.popleft()
        names = ('left', 'right')
        if not others:
            raise StereoLandmarkError(
                f'{names[side]} images come without {names[1 - side]} ones; check that camera'
            )
        raise StereoLandmarkError(
            'left and right images have no stamps in common; trigger both cameras together, or set approximate_sync'
        )
