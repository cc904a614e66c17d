"""Stereo matching of primitives, also where many look the same.

Similar primitives are disambiguated by their neighbours: on surfaces, the disparities of neighbours differ by less than
a fraction of their distance (the disparity gradient limit of Pollard, Mayhew & Frisby 1985). Each candidate pair gets
support from all neighbours with a pair within that limit; pairs with the most support on both sides are matched.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

ROWS_APART = 2.0
"""Maximum row difference of a pair; detections are accurate to about a pixel [px]."""
GRADIENT_MAX = 0.15
"""Maximum disparity gradient: a wall seen at 45° from 3 m with 0.2 m of baseline has 0.07."""
SLACK = 2.0
"""Disparity error besides the gradient [px]."""
NEIGHBOURHOOD = 600.0
"""Radius of the neighbours that give support [px]: large enough to include the end of a row of similar shapes."""
SAME = 4.0
"""Pairs whose disparities differ by less are duplicate detections [px]."""
VOTERS_MAX = 1000
"""Maximum number of supporting neighbours; more are subsampled evenly, since tiled walls have thousands."""
MARGIN = 1.03
"""Minimum ratio of the support to that of the runner-up; below it a pair is ambiguous."""


def match_pairs(
    centres: Sequence[NDArray[np.float64]],
    pairs: Sequence[NDArray[np.int64]],
    disparities: Sequence[NDArray[np.float64]],
    weights: Sequence[float],
    wanted: int,
) -> NDArray[np.int64]:
    """Return the matched pairs of one kind, shape (k, 2). Primitives of all kinds support each other.

    Args:
        centres: centres in the left image for each kind, shape (n, 2) [px].
        pairs: candidate pairs for each kind, shape (m, 2), see `alike_pairs`.
        disparities: disparities of the pairs for each kind, shape (m,) [px].
        weights: support weight of a primitive of each kind.
        wanted: index of the kind to match.
    """
    begin, end = np.cumsum([0, *(len(numbers) for numbers in pairs)])[wanted : wanted + 2]
    asked = np.zeros(sum(len(numbers) for numbers in pairs), dtype=np.bool_)
    asked[begin:end] = contested(pairs[wanted], disparities[wanted])
    first = np.cumsum([0, *(len(each) for each in centres)])
    support = supports(
        np.concatenate([each[numbers[:, 0]] for each, numbers in zip(centres, pairs, strict=True)]),
        np.concatenate(disparities),
        np.concatenate([numbers[:, 0] + base for numbers, base in zip(pairs, first, strict=False)]),
        np.repeat(weights, [len(numbers) for numbers in pairs]),
        asked,
    )
    return np.asarray(
        pairs[wanted][mutual_best(pairs[wanted], disparities[wanted], support[begin:end])], dtype=np.int64
    )


@njit(cache=True, error_model='numpy')
def alike_pairs(
    left: NDArray[np.float64],
    left_shapes: NDArray[np.float64],
    right: NDArray[np.float64],
    right_shapes: NDArray[np.float64],
    disparities: tuple[float, float],
) -> NDArray[np.int64]:
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
        begin = np.searchsorted(rows, left[i, 1] - ROWS_APART)
        for place in range(begin, len(rows)):
            if rows[place] > left[i, 1] + ROWS_APART:
                break
            j = order[place]
            disparity = left[i, 0] - right[j, 0]
            is_near = disparities[0] <= disparity <= disparities[1]
            if is_near and _are_alike(left_shapes[i], right_shapes[j]):
                pairs.append((i, j))
    numbers = np.empty((len(pairs), 2), np.int64)
    for p in range(len(pairs)):
        numbers[p, 0], numbers[p, 1] = pairs[p]
    return numbers


@njit(cache=True, error_model='numpy')
def _are_alike(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    alike = 0
    while alike < len(one) and abs(one[alike] - other[alike]) < 1.0:
        alike += 1
    return alike == len(one)


@njit(cache=True, error_model='numpy')
def supports(
    places: NDArray[np.float64],
    disparities: NDArray[np.float64],
    owners: NDArray[np.int64],
    weights: NDArray[np.float64],
    asked: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Return the support of the neighbours for each requested pair, shape (m,); 0 for the others.

    Args:
        places: centres in the left image, shape (m, 2) [px].
        disparities: disparities of the pairs, shape (m,) [px].
        owners: index of the left primitive of each pair, shape (m,); pairs of one primitive are adjacent.
        weights: support weight of the left primitive of each pair, shape (m,).
        asked: mask of the requested pairs, shape (m,).
    """
    firsts = _firsts(owners)
    layers, sizes, voters = _voters(disparities, firsts)
    count = sizes[0]
    shares, words, least = np.empty(count), np.empty(count), np.empty(count)
    support = np.zeros(len(places))
    for owner in range(len(firsts) - 1):
        begin, end = firsts[owner], firsts[owner + 1]
        if not np.any(asked[begin:end]):
            continue
        for v in range(count):
            first = firsts[voters[v]]
            du, dv = places[first, 0] - places[begin, 0], places[first, 1] - places[begin, 1]
            squared = du * du + dv * dv
            shares[v] = 1.0 / (SLACK + GRADIENT_MAX * np.sqrt(squared))
            is_asked = squared < NEIGHBOURHOOD**2 and voters[v] != owner
            words[v] = weights[first] if is_asked else 0.0
        for p in range(begin, end):
            if asked[p]:
                support[p] = _support(disparities[p], layers, sizes, shares, words, least)
    return support


@njit(cache=True, error_model='numpy')
def _voters(
    disparities: NDArray[np.float64], firsts: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the first disparity of each supporter, then the second of those that have two, and so on.

    Returns:
        rows of disparities, shape (k, n); number of supporters with that many, shape (k,); left indices of the
        supporters, those with the most pairs first, shape (n,).
    """
    step = max((len(firsts) + VOTERS_MAX - 2) // VOTERS_MAX, 1)
    chosen = np.arange(0, len(firsts) - 1, step)
    pairs = firsts[chosen + 1] - firsts[chosen]
    chosen = chosen[np.argsort(-pairs, kind='mergesort')]
    rows = max(np.max(pairs), 1) if len(pairs) else 1
    layers, sizes = np.empty((rows, len(chosen))), np.zeros(rows, np.int64)
    sizes[0] = len(chosen)
    for v in range(len(chosen)):
        begin = firsts[chosen[v]]
        for q in range(begin, firsts[chosen[v] + 1]):
            layers[q - begin, v] = disparities[q]
            sizes[q - begin] = v + 1
    return layers, sizes, chosen


# Summation order is free, so that the loop is vectorized.
@njit(cache=True, error_model='numpy', fastmath={'reassoc', 'nsz', 'contract'})
def _support(
    disparity: float,
    layers: NDArray[np.float64],
    sizes: NDArray[np.int64],
    shares: NDArray[np.float64],
    words: NDArray[np.float64],
    least: NDArray[np.float64],
) -> float:
    for v in range(sizes[0]):
        least[v] = abs(layers[0, v] - disparity)
    for k in range(1, len(sizes)):
        for v in range(sizes[k]):
            least[v] = min(least[v], abs(layers[k, v] - disparity))
    total = 0.0
    for v in range(sizes[0]):
        total += words[v] * max(0.0, 1.0 - least[v] * shares[v])
    return total


@njit(cache=True, error_model='numpy')
def _firsts(owners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the first pair of each left primitive, followed by the number of pairs."""
    firsts = np.empty(len(owners) + 1, np.int64)
    count = 0
    for p in range(len(owners)):
        if p == 0 or owners[p] != owners[p - 1]:
            firsts[count] = p
            count += 1
    firsts[count] = len(owners)
    return firsts[: count + 1]


@njit(cache=True, error_model='numpy')
def contested(pairs: NDArray[np.int64], disparities: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask of pairs that compete for their left or right primitive, shape (m,), except for duplicates.

    Args:
        pairs: candidate pairs of one kind, shape (m, 2).
        disparities: disparities of the pairs, shape (m,) [px].
    """
    alone = np.ones(len(pairs), np.bool_)
    for side in range(2):
        order = np.argsort(pairs[:, side])
        begin = 0
        for end in range(1, len(order) + 1):
            if end < len(order) and pairs[order[end], side] == pairs[order[begin], side]:
                continue
            for a in range(begin, end):
                for b in range(begin, end):
                    if abs(disparities[order[a]] - disparities[order[b]]) > SAME:
                        alone[order[a]] = False
            begin = end
    return ~alone


@njit(cache=True, error_model='numpy')
def mutual_best(
    pairs: NDArray[np.int64], disparities: NDArray[np.float64], support: NDArray[np.float64]
) -> NDArray[np.bool_]:
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
                    rivals = abs(disparities[p] - disparities[q]) > SAME
                    if rivals and support[p] <= MARGIN * support[q]:
                        chosen[p] = False
            begin = end
    return chosen
