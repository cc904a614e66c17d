"""The dots of adjusted blocks, without dirt, together with those of the map that was extended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.adjustment import place_dots
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.sighting_blocks import SightingBlock, SightingBlocks
from floor_localizer.core.survey.sightings import count_views
from floor_localizer.core.survey.survey_image import ViewOutline

_SEVERAL = 2
"""A dot that was seen once though so many images should have seen it is dirt."""


@dataclass(frozen=True)
class Residuals:
    """What the adjustment left over, block by block.

    Attributes:
        shelf: where they are.
        blocks: the sightings they are of.
        scale: by which the map was made larger afterwards.
    """

    shelf: Shelf
    blocks: SightingBlocks
    scale: float = 1.0

    def __iter__(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Yield the images, shape (n,), and the residuals, shape (n, 2) [m], of the sightings of each block."""
        for number, block in enumerate(self.blocks):
            (residuals,) = self.shelf.get('residuals', number)
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


@dataclass
class _Gathered:
    points: list[NDArray[np.float64]] = field(default_factory=list)
    diameters: list[NDArray[np.float64]] = field(default_factory=list)
    counts: list[NDArray[np.int64]] = field(default_factory=list)


def gather_dots(
    blocks: SightingBlocks,
    states: NDArray[np.float64],
    position: NDArray[np.float64],
    outline: ViewOutline,
    existing: DotMap | None,
    shelf: Shelf,
) -> SurveyedDots:
    """Put dots, diameters and counts together, without dirt, and the residuals on the shelf.

    Args:
        blocks: adjusted ones.
        states: shape (k, 6), of all images.
        position: of the optical centre [m].
        outline: what an image shows.
        existing: the map that is extended.
        shelf: for the residuals.
    """
    old = DotMap(np.empty((0, 2)), np.empty(0)) if existing is None else existing
    again, dirt, new = np.zeros(len(old), dtype=np.int64), 0, _Gathered()
    margin = _usual_diameter(blocks, states)
    for number, block in enumerate(blocks):
        dots, residuals = place_dots(block, states, position)
        shelf.put('residuals', number, residuals)
        seen, fixed = np.bincount(block.seen.dot, minlength=len(dots)), block.is_fixed
        if fixed.any():
            _, which = cKDTree(old.points).query(block.fixed_dots[fixed])
            again[which] += seen[fixed]
        is_new = ~fixed & (seen > 0)
        is_dirt = is_new & (seen == 1) & (count_views(dots, states, outline, margin) >= _SEVERAL)
        dirt += int(is_dirt.sum())
        kept = is_new & ~is_dirt
        new.points.append(dots[kept])
        new.diameters.append(_diameters(block, states)[kept])
        new.counts.append(seen[kept])
    dot_map = DotMap(
        np.concatenate([old.points, *new.points]), np.concatenate([old.diameters, *new.diameters])
    )
    return SurveyedDots(dot_map, np.concatenate([again, *new.counts]), dirt, len(old))


def _usual_diameter(blocks: SightingBlocks, states: NDArray[np.float64]) -> float:
    """Return the median of all dots [m]."""
    return float(np.median(np.concatenate([_diameters(block, states) for block in blocks])))


def _diameters(block: SightingBlock, states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean diameter of each dot, shape (m,) [m]."""
    seen, number = block.seen, len(block.fixed_dots)
    total = np.bincount(seen.dot, seen.diameters * (1.0 + states[seen.image, 3]), number)
    return total / np.maximum(np.bincount(seen.dot, minlength=number), 1)
