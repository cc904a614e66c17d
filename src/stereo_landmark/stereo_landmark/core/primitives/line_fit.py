"""Least squares lines through the straight runs between polyline vertices."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

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
    points: NDArray[np.float64],
    vertex_indices: NDArray[np.int32],
    vertex_starts: NDArray[np.int32],
    length_min: float,
) -> NDArray[np.float64]:
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
            if length < length_min or _is_in_arc(
                points, vertex_indices, b, vertex_starts[s], vertex_starts[s + 1]
            ):
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
def _is_in_arc(
    points: NDArray[np.float64], vertex_indices: NDArray[np.int32], b: int, first: int, end: int
) -> bool:
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
    return mean_height * expected_height > 0.0 and abs(mean_height) > _SAGITTA_RATIO_MIN * abs(
        expected_height
    )


@njit(cache=True, error_model='numpy')
def _turning_angle(points: NDArray[np.float64], vertex_indices: NDArray[np.int32], b: int) -> float:
    """Return the angle between the polyline edge after a vertex and the next edge [rad]."""
    ax, ay = points[vertex_indices[b + 1]] - points[vertex_indices[b]]
    bx, by = points[vertex_indices[b + 2]] - points[vertex_indices[b + 1]]
    return np.arctan2(ax * by - ay * bx, ax * bx + ay * by)


@njit(cache=True, error_model='numpy')
def fit_lines(
    sums: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
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
