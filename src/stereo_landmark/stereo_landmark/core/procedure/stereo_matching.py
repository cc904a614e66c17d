"""Kernels of the stereo matching of primitives, also where many look the same.

Similar primitives are disambiguated by their neighbours: on surfaces, the disparities of neighbours differ by less than
a fraction of their distance (the disparity gradient limit of Pollard, Mayhew & Frisby 1985). Each candidate pair gets
support from all neighbours with a pair within that limit; pairs with the most support on both sides are matched.
"""

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints, Masks

ROW_DIFFERENCE_MAX = 2.0
"""Maximum row difference of a pair; detections are accurate to about a pixel [px]."""
DISPARITY_GRADIENT_MAX = 0.15
"""Maximum disparity gradient: a wall seen at 45° from 3 m with 0.2 m of baseline has 0.07."""
DISPARITY_ERROR = 2.0
"""Disparity error besides the gradient [px]."""
SUPPORT_RADIUS = 600.0
"""Radius of the neighbours that give support [px]: large enough to include the end of a row of similar shapes."""
DUPLICATE_DISPARITY = 4.0
"""Pairs whose disparities differ by less are duplicate detections [px]."""
SUPPORTERS_MAX = 1000
"""Maximum number of supporting neighbours; more are subsampled evenly, since tiled walls have thousands."""
SUPPORT_RATIO_MIN = 1.03
"""Minimum ratio of the support to that of the runner-up; below it a pair is ambiguous."""


@njit(cache=True, error_model='numpy')
def candidate_pairs(
    left: Floats, left_shapes: Floats, right: Floats, right_shapes: Floats, disparities: tuple[float, float]
) -> Ints:
    """Return candidate pairs of primitives of one kind, shape (m, 2): index in the left and in the right image.

    Args:
        left: centres in the left image minus the principal point, shape (n, 2) [px].
        left_shapes: descriptors of the left primitives, shape (n, d).
        right: centres in the right image minus the principal point, shape (k, 2) [px].
        right_shapes: descriptors of the right primitives, shape (k, d).
        disparities: smallest and largest disparity [px].
    """
    order = np.argsort(right[:, 1])
    rows = right[order, 1]
    pairs = []
    for i in range(len(left)):
        begin = np.searchsorted(rows, left[i, 1] - ROW_DIFFERENCE_MAX)
        for row in range(begin, len(rows)):
            if rows[row] > left[i, 1] + ROW_DIFFERENCE_MAX:
                break
            j = order[row]
            disparity = left[i, 0] - right[j, 0]
            is_near = disparities[0] <= disparity <= disparities[1]
            if is_near and _are_similar(left_shapes[i], right_shapes[j]):
                pairs.append((i, j))
    numbers = np.empty((len(pairs), 2), np.int64)
    for p in range(len(pairs)):
        numbers[p, 0], numbers[p, 1] = pairs[p]
    return numbers


@njit(cache=True, error_model='numpy')
def _are_similar(one: Floats, other: Floats) -> bool:
    similar = 0
    while similar < len(one) and abs(one[similar] - other[similar]) < 1.0:
        similar += 1
    return similar == len(one)


@njit(cache=True, error_model='numpy')
def neighbour_support(
    positions: Floats, disparities: Floats, left_indices: Ints, weights: Floats, requested: Masks
) -> Floats:
    """Return the support of the neighbours for each requested pair, shape (m,); 0 for the others.

    Args:
        positions: centres in the left image, shape (m, 2) [px].
        disparities: disparities of the pairs, shape (m,) [px].
        left_indices: index of the left primitive of each pair, shape (m,); pairs of one primitive are adjacent.
        weights: support weight of the left primitive of each pair, shape (m,).
        requested: mask of the requested pairs, shape (m,).
    """
    group_starts = _group_starts(left_indices)
    disparity_layers, sizes, supporters = _supporters(disparities, group_starts)
    count = sizes[0]
    inverse_tolerances, support_weights, nearest = np.empty(count), np.empty(count), np.empty(count)
    support = np.zeros(len(positions))
    for left_index in range(len(group_starts) - 1):
        begin, end = group_starts[left_index], group_starts[left_index + 1]
        if not np.any(requested[begin:end]):
            continue
        for v in range(count):
            first = group_starts[supporters[v]]
            du, dv = positions[first, 0] - positions[begin, 0], positions[first, 1] - positions[begin, 1]
            squared = du * du + dv * dv
            inverse_tolerances[v] = 1.0 / (DISPARITY_ERROR + DISPARITY_GRADIENT_MAX * np.sqrt(squared))
            is_supporter = squared < SUPPORT_RADIUS**2 and supporters[v] != left_index
            support_weights[v] = weights[first] if is_supporter else 0.0
        for p in range(begin, end):
            if requested[p]:
                support[p] = _support(
                    disparities[p], disparity_layers, sizes, inverse_tolerances, support_weights, nearest
                )
    return support


@njit(cache=True, error_model='numpy')
def _supporters(disparities: Floats, group_starts: Ints) -> tuple[Floats, Ints, Ints]:
    """Return the first disparity of each supporter, then the second of those that have two, and so on.

    Returns:
        rows of disparities, shape (k, n); number of supporters with that many, shape (k,); left indices of the
        supporters, those with the most pairs first, shape (n,).
    """
    step = max((len(group_starts) + SUPPORTERS_MAX - 2) // SUPPORTERS_MAX, 1)
    chosen = np.arange(0, len(group_starts) - 1, step)
    pairs = group_starts[chosen + 1] - group_starts[chosen]
    chosen = chosen[np.argsort(-pairs, kind='mergesort')]
    rows = max(np.max(pairs), 1) if len(pairs) else 1
    disparity_layers, sizes = np.empty((rows, len(chosen))), np.zeros(rows, np.int64)
    sizes[0] = len(chosen)
    for v in range(len(chosen)):
        begin = group_starts[chosen[v]]
        for q in range(begin, group_starts[chosen[v] + 1]):
            disparity_layers[q - begin, v] = disparities[q]
            sizes[q - begin] = v + 1
    return disparity_layers, sizes, chosen


# Summation order is free, so that the loop is vectorized.
@njit(cache=True, error_model='numpy', fastmath={'reassoc', 'nsz', 'contract'})
def _support(
    disparity: float,
    disparity_layers: Floats,
    sizes: Ints,
    inverse_tolerances: Floats,
    support_weights: Floats,
    nearest: Floats,
) -> float:
    for v in range(sizes[0]):
        nearest[v] = abs(disparity_layers[0, v] - disparity)
    for k in range(1, len(sizes)):
        for v in range(sizes[k]):
            nearest[v] = min(nearest[v], abs(disparity_layers[k, v] - disparity))
    total = 0.0
    for v in range(sizes[0]):
        total += support_weights[v] * max(0.0, 1.0 - nearest[v] * inverse_tolerances[v])
    return total


@njit(cache=True, error_model='numpy')
def _group_starts(left_indices: Ints) -> Ints:
    """Return the first pair of each left primitive, followed by the number of pairs."""
    changes = np.flatnonzero(left_indices[1:] != left_indices[:-1]) + 1
    return np.concatenate((np.array([0]), changes, np.array([len(left_indices)])))


@njit(cache=True, error_model='numpy')
def mutual_best(pairs: Ints, disparities: Floats, support: Floats) -> Masks:
    """Return the mask of pairs with clearly the most support for both their left and right primitive, shape (m,).

    Args:
        pairs: candidate pairs of one kind, shape (m, 2).
        disparities: disparities of the pairs, shape (m,) [px].
        support: support of the pairs, shape (m,).
    """
    chosen = np.ones(len(pairs), np.bool_)
    for side in range(2):
        order = np.argsort(pairs[:, side])
        begin = 0
        for end in range(1, len(order) + 1):
            if end < len(order) and pairs[order[end], side] == pairs[order[begin], side]:
                continue
            for a in range(begin, end):
                for b in range(begin, end):
                    p, q = order[a], order[b]
                    # Duplicate detections do not compete.
                    are_rivals = abs(disparities[p] - disparities[q]) > DUPLICATE_DISPARITY
                    if are_rivals and support[p] <= SUPPORT_RATIO_MIN * support[q]:
                        chosen[p] = False
            begin = end
    return chosen


@njit(cache=True, error_model='numpy')
def is_contested(pairs: Ints, disparities: Floats) -> Masks:
    """Return the mask of pairs that compete for their left or right primitive, shape (m,), except for duplicates.

    Args:
        pairs: candidate pairs of one kind, shape (m, 2).
        disparities: disparities of the pairs, shape (m,) [px].
    """
    # With equal support, no pair has clearly the most.
    return ~mutual_best(pairs, disparities, np.ones(len(pairs)))
