"""The dots of adjusted blocks, without dirt, together with those of the map that was extended."""

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
"""A dot that was seen once though so many images should have seen it is dirt."""


@dataclass(frozen=True)
class Residuals:
    """What the adjustment left over, block by block.

    Attributes:
        blocks: the sightings they are of, on whose shelf they are.
        scale: by which the map was made larger afterwards.
    """

    blocks: SightingBlocks
    scale: float = 1.0

    def __iter__(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Yield the images, shape (n,), and the residuals, shape (n, 2) [m], of the sightings of each block."""
        for number, block in enumerate(self.blocks):
            (residuals,) = self.blocks.shelf.get('residuals', number)
            yield block.seen.image, self.scale * residuals


@dataclass(frozen=True)
class SurveyedDots:
    """The dots of a survey.

    Attributes:
        dot_map: those of the map that was extended, as they were, then the new ones.
        counts: shape (n,), how many images saw each.
        dirt: number of dots that were dropped.
        old_dots: number of those of the old map.
    """

    dot_map: DotMap
    counts: NDArray[np.int64]
    dirt: int
    old_dots: int


def gather_dots(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    outline: ViewOutline,
    existing: DotMap,
    old: OldDots,
    runner: TaskRunner,
) -> SurveyedDots:
    """Put dots, diameters and counts together, without dirt, and the residuals on the shelf.

    Args:
        blocks: adjusted ones.
        states: shape (k, 6), of all images.
        position: of the optical centre [m].
        outline: what an image shows.
        existing: the map that is extended.
        old: its dots.
        runner: of tasks that see the blocks' shelf.
    """
    shelf, numbers = blocks.shelf, range(len(blocks))
    shelf.put('states', 0, states)
    run_numbered(runner, _Measuring(blocks, position), len(blocks), BLOCKS_A_TASK)
    # A dot nearer to the border of an image than its usual diameter may not be whole in it.
    margin = float(np.median(np.concatenate([shelf.get('diameters', number)[0] for number in numbers])))
    middles = outline.middles(states)
    boxes = shelve_boxes(np.stack([middles - outline.reach, middles + outline.reach], axis=1), shelf)
    sifting = _Sifting(blocks, boxes, old, outline, margin)
    run_numbered(runner, sifting, len(blocks), BLOCKS_A_TASK)
    again, dirt = np.zeros(len(existing), dtype=np.int64), 0
    points, diameters, counts = [existing.points], [existing.diameters], list[NDArray[np.int64]]()
    for number in numbers:
        new_points, new_diameters, seen, which, seen_again, dropped = shelf.get('dots', number)
        points.append(new_points)
        diameters.append(new_diameters)
        counts.append(seen)
        again[which] += seen_again
        dirt += int(dropped)
    dot_map = DotMap(np.concatenate(points), np.concatenate(diameters))
    return SurveyedDots(dot_map, np.concatenate([again, *counts]), dirt, len(existing))


@dataclass(frozen=True)
class _Measuring:
    """Puts the residuals of a block's sightings, the places of its dots and their diameters on the shelf."""

    blocks: SightingBlocks
    position: NDArray[np.float64]

    def __call__(self, number: int) -> None:
        shelf, block = self.blocks.shelf, self.blocks[number]
        states, seen, count = shelf.look_up('states'), block.seen, len(block.fixed_dots)
        dots, residuals = place_dots(block, states, self.position)
        total = np.bincount(seen.dot, seen.diameters * (1.0 + states[seen.image, 3]), count)
        shelf.put('residuals', number, residuals)
        shelf.put('places', number, dots)
        shelf.put('diameters', number, total / np.maximum(np.bincount(seen.dot, minlength=count), 1))


@dataclass(frozen=True)
class _Sifting:
    """Puts the new dots of a block that are no dirt on the shelf, and how often the old ones were seen."""

    blocks: SightingBlocks
    boxes: ImageBoxes
    old: OldDots
    outline: ViewOutline
    margin: float

    def __call__(self, number: int) -> None:
        shelf, block = self.blocks.shelf, self.blocks[number]
        (dots,), (diameters,) = shelf.get('places', number), shelf.get('diameters', number)
        seen, fixed = np.bincount(block.seen.dot, minlength=len(dots)), block.is_fixed
        which, points = self.old.around(dots[fixed], 0.0)
        _, same = cKDTree(points).query(dots[fixed])
        once = np.flatnonzero(~fixed & (seen == 1))
        is_dirt = self._views(dots[once]) >= _SEVERAL
        kept = ~fixed & (seen > 0)
        kept[once] = ~is_dirt
        new = dots[kept], diameters[kept], seen[kept]
        shelf.put('dots', number, *new, which[same], seen[fixed], is_dirt.sum())

    def _views(self, dots: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return how many images should have seen each dot, shape (m,)."""
        place = Tile(dots.min(axis=0, initial=np.inf), dots.max(axis=0, initial=-np.inf))
        near = self.blocks.shelf.look_up('states')[self.boxes.meeting(place)]
        return count_views(dots, near, self.outline, self.margin)
