"""Joins collinear line segments over gaps."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Largest angle between two joined line segments [rad].
_ANGLE_MAX = 0.07


@njit(cache=True, error_model='numpy')
def join_collinear(
    ends: NDArray[np.float64], gap_max: float, offset_max: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
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
def _find_successors(ends: NDArray[np.float64], gap_max: float, offset_max: float) -> NDArray[np.int64]:
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
def _gap(
    ends: NDArray[np.float64],
    steps: NDArray[np.float64],
    lengths: NDArray[np.float64],
    i: int,
    j: int,
    offset_max: float,
    gap_max: float,
) -> float:
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
