"""Which primitive of the right image is which of the left one, where many look the same.

Things that look alike are told apart by their neighbours: on surfaces, disparities of neighbours differ by less than a
share of their distance (the disparity gradient limit of Pollard, Mayhew & Frisby 1985). Each pair of primitives gets
support from all neighbours that have a pair within that limit, and pairs win that have the most on both sides.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

ROWS_APART = 2.0
"""Rectified images show a point in the same row, and detection is about a pixel off [px]."""
GRADIENT_MAX = 0.15
"""Of disparities over the image: a wall seen at 45° from 3 m with 0.2 m of baseline has 0.07."""
SLACK = 2.0
"""Error of a disparity [px]."""
NEIGHBOURHOOD = 600.0
"""How far support reaches [px]: far enough to see the end of a row of like things."""
SAME = 4.0
"""Disparities that differ by less are those of one thing that was detected twice [px]."""
MARGIN = 1.03
"""Pairs that have hardly more support than others are not told apart."""


@njit(cache=True)
def alike_pairs(
    left: NDArray[np.float64],
    left_shapes: NDArray[np.float64],
    right: NDArray[np.float64],
    right_shapes: NDArray[np.float64],
    disparities: tuple[float, float],
) -> NDArray[np.int64]:
    """Return which primitives of one kind may be the same, shape (m, 2): number in the left and in the right image.

    Args:
        left: shape (n, 2), centres less the principal point [px].
        left_shapes: shape (n, d), their descriptors.
        right: shape (k, 2).
        right_shapes: shape (k, d).
        disparities: smallest and largest [px].
    """
    order = np.argsort(right[:, 1])
    rows = right[order, 1]
    pairs = []
    for i in range(len(left)):
        begin = np.searchsorted(rows, left[i, 1] - ROWS_APART)
        for place in range(begin, len(rows)):
            if rows[place] > left[i, 1] + ROWS_APART:
                break
            j = order[place]
            disparity = left[i, 0] - right[j, 0]
            is_near = disparities[0] <= disparity <= disparities[1]
            if is_near and np.max(np.abs(left_shapes[i] - right_shapes[j])) < 1.0:
                pairs.append((i, j))
    numbers = np.empty((len(pairs), 2), np.int64)
    for p in range(len(pairs)):
        numbers[p, 0], numbers[p, 1] = pairs[p]
    return numbers


@njit(cache=True)
def supports(
    places: NDArray[np.float64],
    disparities: NDArray[np.float64],
    owners: NDArray[np.int64],
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return how much the neighbours speak for each pair, shape (m,).

    Args:
        places: shape (m, 2), centres in the left image [px].
        disparities: shape (m,) [px].
        owners: shape (m,), which primitive of the left image a pair is of; pairs of one stand together.
        weights: shape (m,), how much the word of that primitive counts.
    """
    support = np.zeros(len(places))
    for p in range(len(places)):
        owner, best, limit, weight = -1, 0.0, 0.0, 0.0
        for q in range(len(places)):
            if owners[q] != owner:
                support[p] += best * weight
                owner, best, weight = owners[q], 0.0, weights[q]
                away = np.hypot(places[q, 0] - places[p, 0], places[q, 1] - places[p, 1])
                counts = owner != owners[p] and away < NEIGHBOURHOOD
                limit = SLACK + GRADIENT_MAX * away if counts else 0.0
            if limit > 0.0:
                best = max(best, 1.0 - abs(disparities[q] - disparities[p]) / limit)
        support[p] += best * weight
    return support


@njit(cache=True)
def mutual_best(
    pairs: NDArray[np.int64], disparities: NDArray[np.float64], support: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return which pairs have clearly the most support of all of their left and of their right primitive, shape (m,).

    Args:
        pairs: shape (m, 2), of one kind.
        disparities: shape (m,) [px].
        support: shape (m,).
    """
    chosen = np.ones(len(pairs), np.bool_)
    for p in range(len(pairs)):
        for q in range(len(pairs)):
            rivals = pairs[p, 0] == pairs[q, 0] or pairs[p, 1] == pairs[q, 1]
            # What was detected twice is no rival.
            rivals = rivals and abs(disparities[p] - disparities[q]) > SAME
            if rivals and support[p] <= MARGIN * support[q]:
                chosen[p] = False
    return chosen
