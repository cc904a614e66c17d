"""Collect the dots of adjusted blocks, without spurious ones, and those of the extended map."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.dots import DotMap
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment.block_partition import ImageBoxes, Tile, store_boxes
from floor_localizer.core.survey.adjustment.observations import (
    ObservationBlock,
    ObservationBlocks,
    count_expected_views,
    project_rays_to_map,
)
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.dot_matching import nearest_pairs
from floor_localizer.core.survey.survey_image import ViewOutline

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
    """Dots of the existing map, sorted by x, in an array store, and their number."""

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


_MIN_EXPECTED_VIEWS = 2  # a dot observed once is spurious if at least this many images should have observed it


@dataclass(frozen=True)
class Residuals:
    """Residuals of the adjustment by block, in its array store; ``scale`` was applied to the map after it."""

    blocks: ObservationBlocks
    scale: float = 1.0

    def __iter__(self) -> Iterator[tuple[Ints, Floats]]:
        """Yield for each block the images, shape (n,), and residuals, shape (n, 2) [m], of its observations."""
        for number, block in enumerate(self.blocks):
            (residuals,) = self.blocks.store.get('residuals', number)
            yield block.observations.image, self.scale * residuals


def collect_dots(
    blocks: ObservationBlocks,
    states: Floats,
    position: Floats,
    outline: ViewOutline,
    existing: DotMap,
    existing_dots: ExistingDots,
    runner: TaskRunner,
) -> tuple[DotMap, Ints, int]:
    """Collect the dots of adjusted blocks without spurious ones; store the residuals.

    ``existing`` is the map to extend, which may be empty, ``existing_dots`` its stored dots.

    Returns:
        the dots of the extended map, unchanged, then the new ones; the number of images that observed each dot, shape
        (n,); and the number of spurious dots that were dropped.
    """
    store, numbers = blocks.store, range(len(blocks))
    store.put('states', 0, states)
    blocks.for_each(runner, _estimate_dots_of_block, position)
    # A dot closer to the image border than the median diameter may be cut off.
    margin = float(np.median(np.concatenate([store.get('diameters', number)[0] for number in numbers])))
    centres = outline.centres(states)
    boxes = store_boxes(np.stack([centres - outline.radius, centres + outline.radius], axis=1), store)
    blocks.for_each(runner, _filter_dots_of_block, boxes, existing_dots, outline, margin)
    existing_counts, spurious_count = np.zeros(len(existing), dtype=np.int64), 0
    points, diameters, counts = [existing.points], [existing.diameters], list[Ints]()
    for number in numbers:
        new_points, new_diameters, new_counts, which, again, dropped = store.get('dots', number)
        points.append(new_points)
        diameters.append(new_diameters)
        counts.append(new_counts)
        existing_counts[which] += again
        spurious_count += int(dropped)
    dot_map = DotMap(np.concatenate(points), np.concatenate(diameters))
    return dot_map, np.concatenate([existing_counts, *counts]), spurious_count


def _estimate_dots_of_block(blocks: ObservationBlocks, position: Floats, number: int) -> None:
    """Store the residuals, dot positions and dot diameters of a block."""
    store, block = blocks.store, blocks[number]
    states, observations, count = store.memory_map('states'), block.observations, len(block.fixed_dots)
    dots, residuals = estimate_dots(block, states, position)
    total = np.bincount(observations.dot, observations.diameters * (1.0 + states[observations.image, 3]), count)
    store.put('residuals', number, residuals)
    store.put('places', number, dots)
    store.put('diameters', number, total / np.maximum(np.bincount(observations.dot, minlength=count), 1))


def _filter_dots_of_block(
    blocks: ObservationBlocks,
    boxes: ImageBoxes,
    existing_dots: ExistingDots,
    outline: ViewOutline,
    margin: float,
    number: int,
) -> None:
    """Store the new dots of a block without spurious ones, and the counts of the existing dots."""
    store, block = blocks.store, blocks[number]
    (dots,), (diameters,) = store.get('places', number), store.get('diameters', number)
    counts, fixed = np.bincount(block.observations.dot, minlength=len(dots)), block.is_fixed
    which, points = existing_dots.query(dots[fixed], 0.0)
    _, same = cKDTree(points).query(dots[fixed])
    once = np.flatnonzero(~fixed & (counts == 1))
    place = Tile(dots[once].min(axis=0, initial=np.inf), dots[once].max(axis=0, initial=-np.inf))
    near = store.memory_map('states')[boxes.overlapping_images(place)]
    is_spurious = count_expected_views(dots[once], near, outline, margin) >= _MIN_EXPECTED_VIEWS
    kept = ~fixed & (counts > 0)
    kept[once] = ~is_spurious
    new = dots[kept], diameters[kept], counts[kept]
    store.put('dots', number, *new, which[same], counts[fixed], is_spurious.sum())
