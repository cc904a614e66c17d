"""Sides: straight parts of segments, joined over gaps; what corners, lines and quadrilaterals are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.collinear import join_collinear
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.primitives.straight_parts import fit_parts, sum_moments
from stereo_landmark.core.segments.segments import Segments


@dataclass(frozen=True)
class Sides:
    """Straight sides; along each the bright side lies to the right.

    Attributes:
        ends: shape (n, 2, 2), first and last point, on the fitted line [px].
        covered: shape (n,), length along which there are edges [px].
        variances: shape (n, 2), of the offset across the line at its middle [px²] and of its direction [rad²].
    """

    ends: NDArray[np.float64]
    covered: NDArray[np.float64]
    variances: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of sides."""
        return len(self.covered)


def find_sides(segments: Segments, settings: PrimitiveSettings) -> Sides:
    """Fit lines to the straight parts of segments and join those that continue each other.

    Where parts were joined, the parts, each two in a row and the whole row are all sides: a row of equal
    panels has sides of its own beside the line through all of them.

    Args:
        segments: segments of the image.
        settings: what is taken for a side.
    """
    sums = sum_moments(segments.points, segments.bends, segments.bend_starts, settings.side_length_min)
    ends, covered, variances = fit_parts(sums)
    members, starts = join_collinear(ends, settings.side_gap_max, settings.side_offset_max)
    more = fit_parts(_united(sums[members], starts))
    return Sides(*(np.concatenate(pair) for pair in zip((ends, covered, variances), more, strict=True)))


def _united(sums: NDArray[np.float64], starts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the moments of groups of parts; where each group begins in them, and their number, shape (m + 1,)."""
    if not len(sums):
        return sums
    # Moments add up; the ends are the first and the last one.
    total = np.add.reduceat(sums, starts[:-1], axis=0)
    total[:, 6:8], total[:, 8:10] = sums[starts[:-1], 6:8], sums[starts[1:] - 1, 8:10]
    return total
