"""Pairs of sides that meet, or would meet if something did not hide the place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

# A side reaches over the vertex by no more than this part of itself; and no gap is longer than the side.
_PART = 0.5


class CornerLinks(NamedTuple):
    """Pairs of ends of sides; end 1 is the last point of a side.

    Attributes:
        sides: shape (n, 2), the two sides.
        ends: shape (n, 2), which end of each.
        vertices: shape (n, 2), where their lines meet [px].
        gaps: shape (n, 2), from each end to the vertex, negative where the side reaches over it [px].
        turns: shape (n,), from going out along the first side to coming in along the second [rad].
    """

    sides: NDArray[np.int64]
    ends: NDArray[np.int64]
    vertices: NDArray[np.float64]
    gaps: NDArray[np.float64]
    turns: NDArray[np.float64]


@njit(cache=True, error_model='numpy')
def link_corners(
    ends: NDArray[np.float64], gap_max: float, overshoot_max: float, angle_min: float
) -> CornerLinks:
    """Return every pair of side ends that make a corner, each pair once.

    Args:
        ends: shape (n, 2, 2), of the sides [px].
        gap_max: how far a side may end before the vertex [px].
        overshoot_max: how far it may reach over it [px].
        angle_min: smallest angle between both lines [rad].
    """
    n = len(ends)
    steps = ends[:, 1] - ends[:, 0]
    reaches = np.minimum(
        gap_max, np.maximum(np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2), overshoot_max)
    )
    order = np.argsort(ends[:, :, 0].copy().reshape(2 * n))
    places = ends.copy().reshape(2 * n, 2)[order]
    reach_of = reaches[order // 2]
    room = 16 * n + 16
    sides, which = np.empty((room, 2), np.int64), np.empty((room, 2), np.int64)
    vertices, gaps, turns = np.empty((room, 2)), np.empty((room, 2)), np.empty(room)
    count = 0
    for a in range(2 * n):
        i, e = order[a] // 2, order[a] % 2
        for b in range(a + 1, 2 * n):
            dx, reach = places[b, 0] - places[a, 0], reach_of[a] + reach_of[b]
            if dx > reach_of[a] + gap_max or count == room:
                break
            if dx > reach or abs(places[b, 1] - places[a, 1]) > reach or order[b] // 2 == i:
                continue
            j, f = order[b] // 2, order[b] % 2
            x, y, gap_i, gap_j, turn = _meet(ends, i, e, j, f, reaches, overshoot_max, angle_min)
            if turn == 0.0:
                continue
            sides[count, 0], sides[count, 1], which[count, 0], which[count, 1] = i, j, e, f
            vertices[count, 0], vertices[count, 1] = x, y
            gaps[count, 0], gaps[count, 1] = gap_i, gap_j
            turns[count] = turn
            count += 1
    return CornerLinks(sides[:count], which[:count], vertices[:count], gaps[:count], turns[:count])


@njit(cache=True, error_model='numpy')
def _meet(
    ends: NDArray[np.float64],
    i: int,
    e: int,
    j: int,
    f: int,
    reaches: NDArray[np.float64],
    overshoot_max: float,
    angle_min: float,
) -> tuple[float, float, float, float, float]:
    """Return the vertex, both gaps and the turn; a turn of 0 where there is no corner."""
    ax, ay = ends[i, e, 0] - ends[i, 1 - e, 0], ends[i, e, 1] - ends[i, 1 - e, 1]
    bx, by = ends[j, f, 0] - ends[j, 1 - f, 0], ends[j, f, 1] - ends[j, 1 - f, 1]
    length_i, length_j = np.sqrt(ax * ax + ay * ay), np.sqrt(bx * bx + by * by)
    ax, ay, bx, by = ax / length_i, ay / length_i, bx / length_j, by / length_j
    cross = ax * by - ay * bx
    if abs(cross) < np.sin(angle_min):
        return 0.0, 0.0, 0.0, 0.0, 0.0
    dx, dy = ends[j, f, 0] - ends[i, e, 0], ends[j, f, 1] - ends[i, e, 1]
    gap_i, gap_j = (dx * by - dy * bx) / cross, (dx * ay - dy * ax) / cross
    for gap, length, reach in ((gap_i, length_i, reaches[i]), (gap_j, length_j, reaches[j])):
        if gap > reach or gap < -min(overshoot_max, _PART * length):
            return 0.0, 0.0, 0.0, 0.0, 0.0
    # Out along the first, in along the second: the second is walked against its outward direction.
    turn = np.arctan2(-cross, -(ax * bx + ay * by))
    return ends[i, e, 0] + gap_i * ax, ends[i, e, 1] + gap_i * ay, gap_i, gap_j, turn
