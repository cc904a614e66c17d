"""Partition of a map for its build: stripes of rows of cells, and ranges of buckets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.dot_grid import BLOCK_ROWS, GridLayout
from floor_localizer.core.constellation.index_rules import IndexRules, index_rules

# Rows of the halo around a stripe that its constellations reach into, plus one for rounding at the end points.
MARGIN_ROWS = 4
_BUCKETS_PER_RANGE = 1 << 20


@dataclass(frozen=True)
class BuildPlan:
    """Parameters of the build, shared by all tasks.

    Attributes:
        folder: folder of the parts.
        chunks: number of chunks of the CSV.
        offsets: x and y of the origin of each level in the map [m].
        frame: grid of cells of the floor.
        rules: parameters of the index.
        dots: number of dots.
        with_diameters: whether any diameter is known.
        stripe_rows: rows of cells in a stripe.
    """

    folder: Path
    chunks: int
    offsets: tuple[tuple[float, float], ...]
    frame: GridLayout
    rules: IndexRules
    dots: int
    with_diameters: bool
    stripe_rows: int

    @property
    def stripes(self) -> int:
        """Number of stripes."""
        return math.ceil(self.frame.rows / self.stripe_rows)

    @property
    def ranges(self) -> int:
        """Number of ranges of buckets."""
        return math.ceil(self.rules.buckets / _BUCKETS_PER_RANGE)

    def rows_of(self, stripe: int) -> tuple[int, int]:
        """Return the first row of a stripe and one past the last."""
        begin = stripe * self.stripe_rows
        return begin, min(begin + self.stripe_rows, self.frame.rows)

    def buckets_of(self, number: int) -> tuple[int, int]:
        """Return the first bucket of a range and one past the last."""
        begin = number * _BUCKETS_PER_RANGE
        return begin, min(begin + _BUCKETS_PER_RANGE, self.rules.buckets)

    def ranges_of(self, buckets: NDArray[np.uint32]) -> NDArray[np.uint16]:
        """Return the range of each bucket, shape (m,)."""
        return (buckets // np.uint32(_BUCKETS_PER_RANGE)).astype(np.uint16)


def plan_build(
    folder: Path,
    chunks: int,
    offsets: tuple[tuple[float, float], ...],
    frame: GridLayout,
    dots: int,
    *,
    with_diameters: bool,
    stripe_dots: int,
) -> BuildPlan:
    """Return the plan for a map.

    Args:
        folder: folder of the parts.
        chunks: number of chunks of the CSV.
        offsets: offsets of the levels, see `BuildPlan`.
        frame: grid of cells of the floor.
        dots: number of dots.
        with_diameters: whether any diameter is known.
        stripe_dots: approximate number of dots in a stripe.

    Raises:
        FloorLocalizerError: there are too many dots for one map.
    """
    blocks = math.ceil(frame.rows / max(math.ceil(dots / stripe_dots), 1) / BLOCK_ROWS)
    return BuildPlan(
        folder,
        chunks,
        offsets,
        frame,
        index_rules(dots, frame.cell),
        dots,
        with_diameters,
        blocks * BLOCK_ROWS,
    )
