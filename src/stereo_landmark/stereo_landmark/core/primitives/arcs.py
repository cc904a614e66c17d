"""Arcs: runs of a segment that curve smoothly to one side."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Ints

# A larger turning angle is a corner [rad]; a polyline edge this many times longer than the next one is straight.
_TURNING_ANGLE_MAX = 1.2
_LENGTH_RATIO_MAX = 5.0
# A shorter or straighter arc does not constrain its ellipse [px, rad].
_LENGTH_MIN = 8.0
_TURN_MIN = 0.4


@njit(cache=True, error_model='numpy')
def find_arcs(
    points: Floats, vertex_indices: NDArray[np.int32], vertex_starts: NDArray[np.int32]
) -> tuple[Ints, Floats]:
    """Return the arcs by falling product of turn and length.

    Args:
        points: points of all segments, shape (n, 2) [px].
        vertex_indices: indices of the polyline vertices in ``points``.
        vertex_starts: start of each segment in ``vertex_indices``, shape (m + 1,).

    Returns:
        first and last point of each arc, shape (k, 2); total turn, positive to the right [rad], and
        length [px] of each arc, shape (k, 2).
    """
    spans, shapes = np.empty((len(vertex_indices) + 1, 2), np.int64), np.empty((len(vertex_indices) + 1, 2))
    count = 0
    for s in range(len(vertex_starts) - 1):
        first, end = vertex_starts[s], vertex_starts[s + 1]
        begin, total_turn = first, 0.0
        for b in range(first + 1, end):
            turn = _smooth_turning_angle(points, vertex_indices, b) if b < end - 1 else 0.0
            if turn * total_turn > 0.0 or (total_turn == 0.0 and turn != 0.0 and begin == b - 1):
                total_turn += turn
                continue
            count += _append_arc(
                points, vertex_indices[begin], vertex_indices[b], total_turn, spans[count], shapes[count]
            )
            # An arc may continue in one of the opposite sense: both share the polyline edge between them.
            begin, total_turn = (b - 1, turn) if turn != 0.0 else (b, 0.0)
    order = np.argsort(-np.abs(shapes[:count, 0]) * shapes[:count, 1])
    return spans[order], shapes[order]


@njit(cache=True, error_model='numpy')
def _smooth_turning_angle(points: Floats, vertex_indices: NDArray[np.int32], b: int) -> float:
    """Return the turning angle at a vertex, 0 at a corner or the end of a straight run [rad]."""
    ax, ay = points[vertex_indices[b]] - points[vertex_indices[b - 1]]
    bx, by = points[vertex_indices[b + 1]] - points[vertex_indices[b]]
    before, after = np.sqrt(ax * ax + ay * ay), np.sqrt(bx * bx + by * by)
    turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    if abs(turn) > _TURNING_ANGLE_MAX or max(before, after) > _LENGTH_RATIO_MAX * min(before, after):
        return 0.0
    return turn


@njit(cache=True, error_model='numpy')
def _append_arc(points: Floats, first: int, last: int, total_turn: float, span: Ints, shape: Floats) -> int:
    length = 0.0
    for i in range(first, last):
        length += np.hypot(points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1])
    if length < _LENGTH_MIN or abs(total_turn) < _TURN_MIN:
        return 0
    span[0], span[1] = first, last
    shape[0], shape[1] = total_turn, length
    return 1
