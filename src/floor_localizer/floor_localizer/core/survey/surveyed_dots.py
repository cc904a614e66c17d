"""Collect the dots of adjusted blocks, without spurious ones, and those of the extended map."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.independent_tasks import TaskRunner, run_numbered
from floor_localizer.core.survey.image_boxes import ImageBoxes, shelve_boxes
from floor_localizer.core.survey.old_dots import OldDots
from floor_localizer.core.survey.placed_dots import place_dots
from floor_localizer.core.survey.sighting_blocks import BLOCKS_A_TASK, SightingBlocks
from floor_localizer.core.survey.sightings import count_views
from floor_localizer.core.survey.survey_image import ViewOutline
from floor_localizer.core.survey.tiles import Tile

_SEVERAL = 2
"""A dot observed once is spurious if at least this many images should have observed it."""


@dataclass(frozen=True)
class Residuals:
    """Residuals of the adjustment, block by block.

    Attributes:
        blocks: the observations; the residuals are in their array store.
        scale: scale factor applied to the map after the adjustment.
    """

    blocks: SightingBlocks
    scale: float = 1.0

    def __iter__(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Yield for each block the images, shape (n,), and residuals, shape (n, 2) [m], of its observations."""
        for number, block in enumerate(self.blocks):
            (residuals,) = self.blocks.shelf.get('residuals', number)
            yield block.seen.image, self.scale * residuals


@dataclass(frozen=True)
class SurveyedDots:
    """The dots of a survey.

    Attributes:
        dot_map: dots of the extended map, unchanged, then the new ones.
        counts: number of images that observed each dot, shape (n,).
        dirt: number of spurious dots that were dropped.
        existing_count: number of dots of the extended map.
    """

    dot_map: DotMap
    counts: NDArray[np.int64]
    dirt: int
    existing_count: int


def gather_dots(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    outline: ViewOutline,
    existing: DotMap,
    old: OldDots,
    runner: TaskRunner,
) -> SurveyedDots:
    """Collect dots, diameters and counts without spurious dots; store the residuals.

    Args:
        blocks: adjusted blocks.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
        outline: outline of a view.
        existing: map to extend, may be empty.
        old: its dots in the array store.
        runner: runs the tasks; they must see the blocks' array store.
    """
    shelf, numbers = blocks.shelf, range(len(blocks))
    shelf.put('states', 0, states)
    run_numbered(runner, _Measuring(blocks, position), len(blocks), BLOCKS_A_TASK)
    # A dot closer to the image border than the median diameter may be cut off.
    margin = float(np.median(np.concatenate([shelf.get('diameters', number)[0] for number in numbers])))
    middles = outline.middles(states)
    boxes = shelve_boxes(np.stack([middles - outline.radius, middles + outline.radius], axis=1), shelf)
    sifting = _Sifting(blocks, boxes, old, outline, margin)
    run_numbered(runner, sifting, len(blocks), BLOCKS_A_TASK)
    existing_counts, dirt = np.zeros(len(existing), dtype=np.int64), 0
    points, diameters, counts = [existing.points], [existing.diameters], list[NDArray[np.int64]]()
    for number in numbers:
        new_points, new_diameters, new_counts, which, again, dropped = shelf.get('dots', number)
        points.append(new_points)
        diameters.append(new_diameters)
        counts.append(new_counts)
        existing_counts[which] += again
        dirt += int(dropped)
    dot_map = DotMap(np.concatenate(points), np.concatenate(diameters))
    return SurveyedDots(dot_map, np.concatenate([existing_counts, *counts]), dirt, len(existing))


@dataclass(frozen=True)
class _Measuring:
    """Stores the residuals, dot positions and dot diameters of a block."""

    blocks: SightingBlocks
    position: NDArray[np.float64]

    def __call__(self, number: int) -> None:
        shelf, block = self.blocks.shelf, self.blocks[number]
        states, observations, count = shelf.look_up('states'), block.seen, len(block.fixed_dots)
        dots, residuals = place_dots(block, states, self.position)
        total = np.bincount(
            observations.dot, observations.diameters * (1.0 + states[observations.image, 3]), count
        )
        shelf.put('residuals', number, residuals)
        shelf.put('places', number, dots)
        shelf.put('diameters', number, total / np.maximum(np.bincount(observations.dot, minlength=count), 1))


@dataclass(frozen=True)
class _Sifting:
    """Stores the new dots of a block without spurious ones, and the counts of the existing dots."""

    blocks: SightingBlocks
    boxes: ImageBoxes
    old: OldDots
    outline: ViewOutline
    margin: float

    def __call__(self, number: int) -> None:
        shelf, block = self.blocks.shelf, self.blocks[number]
        (dots,), (diameters,) = shelf.get('places', number), shelf.get('diameters', number)
        counts, fixed = np.bincount(block.seen.dot, minlength=len(dots)), block.is_fixed
        which, points = self.old.around(dots[fixed], 0.0)
        _, same = cKDTree(points).query(dots[fixed])
        once = np.flatnonzero(~fixed & (counts == 1))
        is_dirt = self._views(dots[once]) >= _SEVERAL
        kept = ~fixed & (counts > 0)
        kept[once] = ~is_dirt
        new = dots[kept], diameters[kept], counts[kept]
        shelf.put('dots', number, *new, which[same], counts[fixed], is_dirt.sum())

    def _views(self, dots: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the number of images that should have observed each dot, shape (m,)."""
        place = Tile(dots.min(axis=0, initial=np.inf), dots.max(axis=0, initial=-np.inf))
        near = self.blocks.shelf.look_up('states')[self.boxes.meeting(place)]
        return count_views(dots, near, self.outline, self.margin)
