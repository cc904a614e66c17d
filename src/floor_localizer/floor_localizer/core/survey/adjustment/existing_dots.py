"""The dots of a map to extend, in an array store from which only a region is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment.dot_estimation import estimate_dots
from floor_localizer.core.survey.adjustment.observations import ObservationBlock, ObservationBlocks
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.dot_matching import nearest_pairs


@dataclass(frozen=True)
class ExistingDots:
    """Dots of the existing map, sorted by x.

    Attributes:
        store: array store of the dots.
        count: number of dots.
    """

    store: ArrayStore
    count: int

    def query(self, places: Floats, max_distance: float) -> tuple[Ints, Floats]:
        """Return all dots within a distance of the bounding box of some points, shape (m, 2) [m].

        Returns:
            the indices, ascending, shape (k,), and the dots, shape (k, 2) [m].
        """
        if len(places) == 0 or self.count == 0:
            return np.empty(0, dtype=np.int64), np.empty((0, 2))
        lower, upper = places.min(axis=0) - max_distance, places.max(axis=0) + max_distance
        sorted_dots, indices = self.store.memory_map('existing'), self.store.memory_map('existing_indices')
        begin = np.searchsorted(sorted_dots[:, 0], lower[0])
        end = np.searchsorted(sorted_dots[:, 0], upper[0], side='right')
        strip = np.array(sorted_dots[begin:end])
        rows = np.flatnonzero((strip[:, 1] >= lower[1]) & (strip[:, 1] <= upper[1]))
        rows = rows[np.argsort(indices[begin + rows])]
        return np.array(indices[begin + rows]), strip[rows]


def store_existing_dots(points: Floats, store: ArrayStore) -> ExistingDots:
    """Store the dots of the existing map, shape (n, 2) [m]."""
    order = np.argsort(points[:, 0], kind='stable')
    store.put('existing', 0, points[order])
    store.put('existing_indices', 0, order)
    return ExistingDots(store, len(points))


def fix_dots(
    blocks: ObservationBlocks,
    states: Floats,
    position: Floats,
    existing_dots: ExistingDots,
    max_distance: float,
    runner: TaskRunner,
) -> None:
    """Fix the dots of blocks without fixed dots that match dots of the existing map within a distance [m], one
    to one; the nearest dot wins. The blocks are overwritten.
    """
    store = blocks.store
    store.put('states', 0, states)
    blocks.for_each(runner, _pair_dots_of_block, position, existing_dots, max_distance)
    pairs = [store.get('pairs', number) for number in range(len(blocks))]
    block = np.repeat(np.arange(len(blocks)), [len(existing_indices) for existing_indices, _ in pairs])
    existing_indices, distance = (np.concatenate(column) for column in zip(*pairs, strict=True))
    order = np.lexsort((block, distance, existing_indices))
    _, first = np.unique(existing_indices[order], return_index=True)
    is_nearest = np.zeros(len(existing_indices), dtype=np.bool_)
    is_nearest[order[first]] = True
    for number in range(len(blocks)):
        store.put('nearest', number, is_nearest[block == number])
    blocks.for_each(runner, _fix_dots_of_block)


def _pair_dots_of_block(
    blocks: ObservationBlocks, position: Floats, existing_dots: ExistingDots, max_distance: float, number: int
) -> None:
    """Store the pairs of dots of a block and of the existing map: index in the map, and distance."""
    store = blocks.store
    dots, _ = estimate_dots(blocks[number], store.memory_map('states'), position)
    existing_indices, points = existing_dots.query(dots, max_distance)
    dot_indices, near = nearest_pairs(points, dots, max_distance)
    store.put('pairs', number, existing_indices[near], np.hypot(*(dots[dot_indices] - points[near]).T))
    store.put('paired', number, dot_indices, points[near])


def _fix_dots_of_block(blocks: ObservationBlocks, number: int) -> None:
    """Fix the dots of a block that are the nearest to their dot of the existing map among all blocks."""
    store, block = blocks.store, blocks[number]
    (is_nearest,), (dot_indices, points) = store.get('nearest', number), store.get('paired', number)
    fixed = block.fixed_dots.copy()
    fixed[dot_indices[is_nearest]] = points[is_nearest]
    blocks.put(number, ObservationBlock(block.observations, fixed))
