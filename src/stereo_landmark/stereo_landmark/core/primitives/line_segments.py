"""Straight line segments, joined over gaps: the input of the corner, parallel line and quadrilateral detectors."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Ints
from stereo_landmark.core.edges.edges import Segments
from stereo_landmark.core.settings import PrimitiveSettings


@dataclass(frozen=True)
class LineSegments:
    """Straight line segments; the bright side is on the right of each.

    Attributes:
        ends: first and last point on the fitted line, shape (n, 2, 2) [px].
        support: length of the supporting edges, without gaps, shape (n,) [px].
        variances: variances of the offset at the middle [px²] and of the direction [rad²], shape (n, 2).
    """

    ends: Floats
    support: Floats
    variances: Floats

    def __len__(self) -> int:
        return len(self.support)


def fit_line_segments(segments: Segments, settings: PrimitiveSettings) -> LineSegments:
    """Fit lines to the straight runs of segments and join collinear ones.

    The result has the runs, each joined pair of neighbours and each whole joined row: a row of equal panels
    has its own sides besides the line through all of them.
    """
    sums = sum_moments(segments.points, segments.vertex_indices, segments.vertex_starts, settings.side_length_min)
    ends, support, variances = fit_lines(sums)
    members, starts = join_collinear(ends, settings.side_gap_max, settings.side_offset_max)
    joined = fit_lines(_sum_groups(sums[members], starts))
    return LineSegments(*(np.concatenate(pair) for pair in zip((ends, support, variances), joined, strict=True)))


def _sum_groups(sums: Floats, starts: Ints) -> Floats:
    """Return the moments of groups of runs; ``starts`` has the start of each group, shape (m + 1,)."""
    if not len(sums):
        return sums
    # Moments are additive; the end points are the first and the last one.
    total = np.add.reduceat(sums, starts[:-1], axis=0)
    total[:, 6:8], total[:, 8:10] = sums[starts[:-1], 6:8], sums[starts[1:] - 1, 8:10]
    return total


# The filter rounds the edge near a vertex: points to skip at each end, and minimum length of a run for skipping.
_SKIPPED_POINTS = 2
_SKIP_COUNT_MIN = 10
# A run whose angles to both neighbours are smaller than this can belong to an arc [rad]; smallest sagitta ratio.
_SMOOTH_ANGLE_MAX = 0.6
_SAGITTA_RATIO_MIN = 0.5
# Mean height of a flat arc over its chord, as a fraction of its sagitta.
_MEAN_TO_SAGITTA = 2.0 / 3.0
# Lower limit of the noise of an edge point [px]; neighbouring edge points have correlated noise [points].
_SIGMA_MIN = 0.05
_NOISE_CORRELATION = 3.0


@njit(cache=True, error_model='numpy')
def sum_moments(
    points: Floats, vertex_indices: NDArray[np.int32], vertex_starts: NDArray[np.int32], length_min: float
) -> Floats:
    """Return the moments of each straight run: n, Σx, Σy, Σx², Σxy, Σy², first point, last point, length.

    Args:
        points: points of all segments, shape (n, 2) [px].
        vertex_indices: indices of the polyline vertices in ``points``.
        vertex_starts: start of each segment in ``vertex_indices``, shape (m + 1,).
        length_min: minimum length of a run [px]; shorter runs and arcs are skipped.

    Returns:
        moments, shape (k, 11).
    """
    sums = np.zeros((len(vertex_indices), 11))
    count = 0
    for s in range(len(vertex_starts) - 1):
        for b in range(vertex_starts[s], vertex_starts[s + 1] - 1):
            first, last = vertex_indices[b], vertex_indices[b + 1]
            length = np.hypot(points[last, 0] - points[first, 0], points[last, 1] - points[first, 1])
            if length < length_min or _is_in_arc(points, vertex_indices, b, vertex_starts[s], vertex_starts[s + 1]):
                continue
            skipped = _SKIPPED_POINTS if last - first + 1 >= _SKIP_COUNT_MIN else 0
            row = sums[count]
            for i in range(first + skipped, last - skipped + 1):
                x, y = points[i]
                row[0] += 1.0
                row[1] += x
                row[2] += y
                row[3] += x * x
                row[4] += x * y
                row[5] += y * y
            row[6], row[7] = points[first]
            row[8], row[9] = points[last]
            row[10] = length
            count += 1
    return sums[:count].copy()


@njit(cache=True, error_model='numpy')
def _is_in_arc(points: Floats, vertex_indices: NDArray[np.int32], b: int, first: int, end: int) -> bool:
    if b == first or b + 2 >= end:
        return False
    before, after = _turning_angle(points, vertex_indices, b - 1), _turning_angle(points, vertex_indices, b)
    if before * after <= 0.0 or max(abs(before), abs(after)) > _SMOOTH_ANGLE_MAX:
        return False
    # An arc with these turning angles has a sagitta; a straight side with rounded corners has none.
    p = points[vertex_indices[b]]
    dx, dy = points[vertex_indices[b + 1]] - p
    squared = dx * dx + dy * dy
    mean_height = 0.0
    for i in range(vertex_indices[b] + 1, vertex_indices[b + 1]):
        mean_height += dy * (points[i, 0] - p[0]) - dx * (points[i, 1] - p[1])
    mean_height /= max(vertex_indices[b + 1] - vertex_indices[b] - 1, 1) * np.sqrt(squared)
    expected_height = np.sqrt(squared) * 0.5 * (before + after) / 8.0 * _MEAN_TO_SAGITTA
    return mean_height * expected_height > 0.0 and abs(mean_height) > _SAGITTA_RATIO_MIN * abs(expected_height)


@njit(cache=True, error_model='numpy')
def _turning_angle(points: Floats, vertex_indices: NDArray[np.int32], b: int) -> float:
    """Return the angle between the polyline edge after a vertex and the next edge [rad]."""
    ax, ay = points[vertex_indices[b + 1]] - points[vertex_indices[b]]
    bx, by = points[vertex_indices[b + 2]] - points[vertex_indices[b + 1]]
    return np.arctan2(ax * by - ay * bx, ax * bx + ay * by)


@njit(cache=True, error_model='numpy')
def fit_lines(sums: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the total least squares lines: ends (k, 2, 2), lengths (k,), variances (k, 2).

    Args:
        sums: moments from :func:`sum_moments`, shape (k, 11).
    """
    k = len(sums)
    ends, lengths, variances = np.empty((k, 2, 2)), np.empty(k), np.empty((k, 2))
    for i in range(k):
        n = sums[i, 0]
        x, y = sums[i, 1] / n, sums[i, 2] / n
        xx, xy, yy = sums[i, 3] / n - x * x, sums[i, 4] / n - x * y, sums[i, 5] / n - y * y
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        dx, dy = np.cos(angle), np.sin(angle)
        if dx * (sums[i, 8] - sums[i, 6]) + dy * (sums[i, 9] - sums[i, 7]) < 0.0:
            dx, dy = -dx, -dy
        for e in range(2):
            along = dx * (sums[i, 6 + 2 * e] - x) + dy * (sums[i, 7 + 2 * e] - y)
            ends[i, e, 0], ends[i, e, 1] = x + along * dx, y + along * dy
        lengths[i] = sums[i, 10]
        spread = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)
        residual_variance = max(xx + yy - spread, _SIGMA_MIN**2)
        variances[i, 0] = residual_variance * _NOISE_CORRELATION / n
        variances[i, 1] = variances[i, 0] / max(spread, 1.0)
    return ends, lengths, variances


# Largest angle between two joined line segments [rad].
_ANGLE_MAX = 0.07


@njit(cache=True, error_model='numpy')
def join_collinear(ends: Floats, gap_max: float, offset_max: float) -> tuple[Ints, Ints]:
    """Return groups of collinear segments in order: each pair of neighbours, and each whole row of three or more.

    Args:
        ends: first and last point of each line segment, shape (n, 2, 2) [px].
        gap_max: longest gap, as a fraction of the summed lengths of both segments.
        offset_max: largest distance of an end point from the other segment's line [px].

    Returns:
        members of all groups, concatenated; start of each group, shape (m + 1,).
    """
    n = len(ends)
    successors = _find_successors(ends, gap_max, offset_max)
    has_predecessor = np.zeros(n, np.bool_)
    for i in range(n):
        if successors[i] >= 0:
            has_predecessor[successors[i]] = True
    members, starts = np.empty(3 * n, np.int64), np.zeros(2 * n + 1, np.int64)
    count, filled = 0, 0
    for first in range(n):
        if has_predecessor[first] or successors[first] < 0:
            continue
        length, i = 1, first
        while successors[i] >= 0:
            members[filled], members[filled + 1] = i, successors[i]
            filled, count, length = filled + 2, count + 1, length + 1
            starts[count] = filled
            i = successors[i]
        if length > 2:
            i = first
            while i >= 0:
                members[filled] = i
                filled, i = filled + 1, successors[i]
            count += 1
            starts[count] = filled
    return members[:filled].copy(), starts[: count + 1].copy()


@njit(cache=True, error_model='numpy')
def _find_successors(ends: Floats, gap_max: float, offset_max: float) -> Ints:
    """Return the successor of each segment, -1 for none; successors are mutual nearest neighbours."""
    n = len(ends)
    steps = ends[:, 1] - ends[:, 0]
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    order = np.argsort(angles)
    successors, predecessors = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    successor_gaps, predecessor_gaps = np.full(n, np.inf), np.full(n, np.inf)
    for a in range(n):
        i = order[a]
        for b in range(1, n):
            # In circular order of direction the candidates are contiguous.
            j = order[a + b] if a + b < n else order[a + b - n]
            if angles[j] - angles[i] + (0.0 if a + b < n else 2.0 * np.pi) > _ANGLE_MAX:
                break
            for first, second in ((i, j), (j, i)):
                longest = gap_max * (lengths[i] + lengths[j])
                gap = _gap(ends, steps, lengths, first, second, offset_max, longest)
                if gap == np.inf:
                    continue
                if gap < successor_gaps[first]:
                    successor_gaps[first], successors[first] = gap, second
                if gap < predecessor_gaps[second]:
                    predecessor_gaps[second], predecessors[second] = gap, first
    for i in range(n):
        if successors[i] >= 0 and predecessors[successors[i]] != i:
            successors[i] = -1
    return successors


@njit(cache=True, error_model='numpy')
def _gap(ends: Floats, steps: Floats, lengths: Floats, i: int, j: int, offset_max: float, gap_max: float) -> float:
    """Return the gap from the end of i to the start of j [px], infinite if they are not collinear or too far apart."""
    dx, dy = ends[j, 0, 0] - ends[i, 1, 0], ends[j, 0, 1] - ends[i, 1, 1]
    along = (dx * steps[i, 0] + dy * steps[i, 1]) / lengths[i]
    if not -offset_max <= along <= gap_max:
        return np.inf
    long, short, sign = (i, j, 0) if lengths[i] >= lengths[j] else (j, i, 1)
    anchor = ends[long, 1 - sign]
    for e in range(2):
        ex, ey = ends[short, e, 0] - anchor[0], ends[short, e, 1] - anchor[1]
        if abs(steps[long, 0] * ey - steps[long, 1] * ex) > offset_max * lengths[long]:
            return np.inf
    return max(along, 0.0)
