"""The index: every small constellation of six map dots, sorted by its key."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import (
    LANES,
    OTHERS,
    X_LOWER,
    X_STEPS,
    Y_LOWER,
    Y_STEPS,
    base_coordinates,
    bucket_of_code,
    imbalance,
    pack,
    to_steps,
    turn_around,
)
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.lens import MOST_GROUPS, MOST_IN_LENS, distance, dots_in_lens, groups_of_four

# A base is indexed when at most this many dots are in its lens.
MOST_INDEXED = 6
# Longest base in units of the mean spacing of dots.
_WIDEST = 3.0
_NEIGHBOURS = 64


class ConstellationIndex(NamedTuple):
    """Constellations of six dots by their key; the arrays may be memory-mapped.

    Attributes:
        codes: shape (M,) uint64, the packed key of each constellation, bucket by bucket.
        bases: shape (M, 2) uint32, its base: the grid's indices of the dots at (0, 0) and (1, 0).
        starts: shape (2**bits + 1,) uint32, where each bucket begins.
        bits: number of bits of a bucket's number.
        reach: the longest base [m].
    """

    codes: NDArray[np.uint64]
    bases: NDArray[np.uint32]
    starts: NDArray[np.uint32]
    bits: int
    reach: float


def build_constellation_index(grid: DotGrid) -> ConstellationIndex:
    """Index the smallest constellations around every dot, about sixteen each.

    Few large constellations tell places apart as well as many small ones, and sixteen a dot leave some whole when half
    of the dots are missing. The size follows the density around each dot, so sparse places are indexed like dense ones.
    """
    widest = _WIDEST * grid.cell
    counts = np.zeros(len(grid.points), dtype=np.int64)
    none = np.empty(0, dtype=np.uint64), np.empty((0, 2), dtype=np.uint32)
    _list_constellations(grid, widest, counts, *none)
    places = np.concatenate([[0], np.cumsum(counts)])
    codes = np.empty(places[-1], dtype=np.uint64)
    bases = np.empty((places[-1], 2), dtype=np.uint32)
    reach = _list_constellations(grid, widest, places[:-1].copy(), codes, bases)
    bits = max(math.ceil(math.log2(max(len(codes), 2))), 1)
    starts = np.zeros((1 << bits) + 1, dtype=np.uint32)
    order = _sort_into_buckets(codes, bits, starts)
    codes, bases = codes[order], bases[order]
    for array in (codes, bases, starts):
        array.flags.writeable = False
    return ConstellationIndex(codes, bases, starts, bits, reach)


@njit(cache=True)
def _list_constellations(
    grid: DotGrid, widest: float, places: NDArray[np.int64], codes: NDArray[np.uint64], bases: NDArray[np.uint32]
) -> float:
    """Count the constellations whose base begins at each dot, and write them where there is room for them.

    Args:
        places: shape (N,), where each dot's constellations go in ``codes``; advanced by their number.
        codes: shape (M,), the keys, or empty to count only.
        bases: shape (M, 2), their bases.

    Returns:
        the longest base [m].
    """
    near = np.empty(_NEIGHBOURS, dtype=np.int64)
    lens = np.empty(MOST_IN_LENS, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    reach = 0.0
    for first in range(len(grid.points)):
        count = dots_within(grid, grid.points[first, 0], grid.points[first, 1], widest, near)
        for second in near[:count]:
            if second <= first:
                continue
            length = distance(grid.points, first, second)
            inside = dots_in_lens(grid.points, first, second, near[:count], length, lens)
            if inside < OTHERS or inside > MOST_INDEXED:
                continue
            found = groups_of_four(grid.points, lens[:inside], length, groups)
            if found > 0:
                reach = max(reach, length)
            if len(codes) > 0:
                for g in range(found):
                    _write_constellation(grid.points, first, second, groups[g], codes, bases, places[first] + g)
            places[first] += found
    return reach


@njit(cache=True)
def _write_constellation(
    points: NDArray[np.float32], first: int, second: int, others: NDArray[np.int64],
    codes: NDArray[np.uint64], bases: NDArray[np.uint32], place: int,
) -> None:
    """Write one constellation in its canonical order: the others more on the side of the first end, sorted by x."""
    xy = np.empty((OTHERS, 2))
    steps = np.empty(LANES, dtype=np.int64)
    base_coordinates(points, first, second, others, xy)
    if imbalance(xy) > 0.0:
        turn_around(xy)
        first, second = second, first
    order = np.argsort(xy[:, 0])
    for k in range(OTHERS):
        steps[2 * k] = to_steps(xy[order[k], 0], X_LOWER, X_STEPS)
        steps[2 * k + 1] = to_steps(xy[order[k], 1], Y_LOWER, Y_STEPS)
    codes[place] = pack(steps)
    bases[place, 0] = first
    bases[place, 1] = second


@njit(cache=True)
def _sort_into_buckets(
    codes: NDArray[np.uint64], bits: int, starts: NDArray[np.uint32]
) -> NDArray[np.int64]:
    """Fill ``starts`` and return the order that puts the codes bucket by bucket (a counting sort)."""
    cells = np.empty(LANES, dtype=np.int64)
    buckets = np.empty(len(codes), dtype=np.int64)
    for i in range(len(codes)):
        buckets[i] = bucket_of_code(codes[i], bits, cells)
        starts[buckets[i] + 1] += np.uint32(1)
    for b in range(len(starts) - 1):
        starts[b + 1] += starts[b]
    place = starts[:-1].astype(np.int64)
    order = np.empty(len(codes), dtype=np.int64)
    for i in range(len(codes)):
        order[place[buckets[i]]] = i
        place[buckets[i]] += 1
    return order
