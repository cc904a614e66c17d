"""Estimate the dots from projected observations; drop outliers; fix dots that are in the map to extend.

A ray d of an image with the state x, y, yaw, scale, roll, pitch meets the floor at p(state, d). A dot is the weighted
mean of its observations, robust against outliers (Huber), or its fixed position.
"""

from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment.observations import ObservationBlock, ObservationBlocks, project_rays_to_map
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.dot_matching import nearest_pairs

_HUBER = 2.5
_OUTLIER_GATE = 8.0  # [standard deviations]


def estimate_dots(block: ObservationBlock, states: Floats, position: Floats) -> tuple[Floats, Floats]:
    """Return the dots of a block, shape (m, 2), and the residuals of its observations, shape (n, 2) [m]."""
    points = project_rays_to_map(block.observations.directions, position, states[block.observations.image])
    dots = weighted_means(block, points, huber_weights(block, points))
    return dots, points - dots[block.observations.dot]


def weighted_means(block: ObservationBlock, points: Floats, weights: Floats) -> Floats:
    """Return the weighted means of the observations of each dot; fixed dots keep their position."""
    dot, number = block.observations.dot, len(block.fixed_dots)
    total = np.maximum(np.bincount(dot, weights, number), 1e-30)
    means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
    return np.where(block.is_fixed[:, None], block.fixed_dots, means)


def huber_weights(block: ObservationBlock, points: Floats) -> Floats:
    """Return the Huber weights divided by the variances, shape (n,)."""
    observations = block.observations
    dots = weighted_means(block, points, 1.0 / observations.sigmas**2)
    length = np.hypot(*(points - dots[observations.dot]).T) / observations.sigmas
    return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / observations.sigmas**2


def drop_outliers(blocks: ObservationBlocks, states: Floats, position: Floats, runner: TaskRunner) -> None:
    """Drop observations whose residual exceeds the gate; the blocks are overwritten."""
    blocks.store.put('states', 0, states)
    blocks.for_each(runner, _drop_of_block, position)


def _drop_of_block(blocks: ObservationBlocks, position: Floats, number: int) -> None:
    block = blocks[number]
    _, residuals = estimate_dots(block, blocks.store.memory_map('states'), position)
    kept = np.hypot(*residuals.T) <= _OUTLIER_GATE * block.observations.sigmas
    blocks.put(number, ObservationBlock(block.observations.where(kept), block.fixed_dots))


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
