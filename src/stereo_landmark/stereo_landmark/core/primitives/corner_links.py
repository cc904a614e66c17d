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
    # By end: where it is, the unit vector that goes on over it, the side's length and its reach.
    outward, lengths = np.empty((2 * n, 2)), np.empty(2 * n)
    for i in range(n):
        dx, dy = ends[i, 1] - ends[i, 0]
        length = np.sqrt(dx * dx + dy * dy)
        for e in range(2):
            sign = 2.0 * e - 1.0
            outward[2 * i + e, 0], outward[2 * i + e, 1] = sign * dx / length, sign * dy / length
            lengths[2 * i + e] = length
    order = np.argsort(ends[:, :, 0].copy().reshape(2 * n))
    places, outward, lengths = ends.copy().reshape(2 * n, 2)[order], outward[order], lengths[order]
    reaches = np.minimum(gap_max, np.maximum(lengths, overshoot_max))
    overshoots = np.minimum(overshoot_max, _PART * lengths)
    columns, rows = places[:, 0].copy(), places[:, 1].copy()
    sine_min = np.sin(angle_min)
    pairs, gaps = np.empty((16 * n + 16, 2), np.int64), np.empty((16 * n + 16, 2))
    count = 0
    for a in range(2 * n):
        far = reaches[a] + gap_max
        for b in range(a + 1, 2 * n):
            dx, dy = columns[b] - columns[a], rows[b] - rows[a]
            if dx > far or count == len(pairs):
                break
            if abs(dy) > far:
                continue
            reach = reaches[a] + reaches[b]
            if dx > reach or abs(dy) > reach or order[a] // 2 == order[b] // 2:
                continue
            cross = outward[a, 0] * outward[b, 1] - outward[a, 1] * outward[b, 0]
            if abs(cross) < sine_min:
                continue
            gap_a = (dx * outward[b, 1] - dy * outward[b, 0]) / cross
            gap_b = (dx * outward[a, 1] - dy * outward[a, 0]) / cross
            if -overshoots[a] <= gap_a <= reaches[a] and -overshoots[b] <= gap_b <= reaches[b]:
                pairs[count, 0], pairs[count, 1], gaps[count, 0], gaps[count, 1] = a, b, gap_a, gap_b
                count += 1
    return _described(pairs[:count], gaps[:count], order, places, outward)


@njit(cache=True, error_model='numpy')
def _described(
    pairs: NDArray[np.int64],
    gaps: NDArray[np.float64],
    order: NDArray[np.int64],
    places: NDArray[np.float64],
    outward: NDArray[np.float64],
) -> CornerLinks:
    n = len(pairs)
    sides, which = np.empty((n, 2), np.int64), np.empty((n, 2), np.int64)
    vertices, turns = np.empty((n, 2)), np.empty(n)
    for k in range(n):
        a, b = pairs[k]
        for c in range(2):
            sides[k, c], which[k, c] = order[pairs[k, c]] // 2, order[pairs[k, c]] % 2
            vertices[k, c] = places[a, c] + gaps[k, 0] * outward[a, c]
        # Out along the first, in along the second: the second is walked against its outward direction.
        cross = outward[a, 0] * outward[b, 1] - outward[a, 1] * outward[b, 0]
        turns[k] = np.arctan2(-cross, -(outward[a, 0] * outward[b, 0] + outward[a, 1] * outward[b, 1]))
    return CornerLinks(sides, which, vertices, gaps.copy(), turns)
