"""Collect the dots of adjusted blocks, without spurious ones, and those of the extended map."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.dots import DotMap
from floor_localizer.core.independent_tasks import TaskRunner
from floor_localizer.core.survey.adjustment.block_partition import ImageBoxes, Tile, store_boxes
from floor_localizer.core.survey.adjustment.dot_estimation import ExistingDots, estimate_dots
from floor_localizer.core.survey.adjustment.observation_merging import count_expected_views
from floor_localizer.core.survey.adjustment.observations import ObservationBlocks
from floor_localizer.core.survey.survey_image import ViewOutline

_MIN_EXPECTED_VIEWS = 2
"""A dot observed once is spurious if at least this many images should have observed it."""


@dataclass(frozen=True)
class Residuals:
    """Residuals of the adjustment, block by block.

    Attributes:
        blocks: the observations; the residuals are in their array store.
        scale: scale factor applied to the map after the adjustment.
    """

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
