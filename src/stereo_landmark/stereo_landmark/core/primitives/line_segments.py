"""Straight line segments, joined over gaps: the input of the corner, parallel line and quadrilateral detectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.collinear import join_collinear
from stereo_landmark.core.primitives.line_fit import fit_lines, sum_moments
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.segments.segments import Segments


@dataclass(frozen=True)
class LineSegments:
    """Straight line segments; the bright side is on the right of each.

    Attributes:
        ends: first and last point on the fitted line, shape (n, 2, 2) [px].
        support: length of the supporting edges, without gaps, shape (n,) [px].
        variances: variances of the offset at the middle [px²] and of the direction [rad²], shape (n, 2).
    """

    ends: NDArray[np.float64]
    support: NDArray[np.float64]
    variances: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of line segments."""
        return len(self.support)


def fit_line_segments(segments: Segments, settings: PrimitiveSettings) -> LineSegments:
    """Fit lines to the straight runs of segments and join collinear ones.

    The result has the runs, each joined pair of neighbours and each whole joined row: a row of equal panels
    has its own sides besides the line through all of them.

    Args:
        segments: segments of the image.
        settings: detection settings.
    """
    sums = sum_moments(
        segments.points, segments.vertex_indices, segments.vertex_starts, settings.side_length_min
    )
    ends, support, variances = fit_lines(sums)
    members, starts = join_collinear(ends, settings.side_gap_max, settings.side_offset_max)
    joined = fit_lines(_sum_groups(sums[members], starts))
    return LineSegments(
        *(np.concatenate(pair) for pair in zip((ends, support, variances), joined, strict=True))
    )


def _sum_groups(sums: NDArray[np.float64], starts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the moments of groups of runs; ``starts`` has the start of each group, shape (m + 1,)."""
    if not len(sums):
        return sums
    # Moments are additive; the end points are the first and the last one.
    total = np.add.reduceat(sums, starts[:-1], axis=0)
    total[:, 6:8], total[:, 8:10] = sums[starts[:-1], 6:8], sums[starts[1:] - 1, 8:10]
    return total
