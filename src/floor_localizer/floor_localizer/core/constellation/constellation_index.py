"""The index: every small constellation of six map dots, sorted by its key."""

from __future__ import annotations

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
from floor_localizer.core.constellation.lens import MOST_GROUPS, distance, groups_on_base

CONSTELLATIONS_PER_DOT = 16.0
_SAMPLE = 4000
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
    """Index all constellations up to the size at which there are about ten for every dot.

    Few large constellations tell places apart as well as many small ones, and ten a dot leave some whole when half of
    the dots are missing. The size follows from the map alone, so it suits any density.
    """
    reach = _choose_reach(grid)
    counts = np.zeros(len(grid.points), dtype=np.int64)
    _count_constellations(grid, reach, 1, counts, np.empty(0))
    total = int(counts.sum())
    codes = np.empty(total, dtype=np.uint64)
    bases = np.empty((total, 2), dtype=np.uint32)
    _list_constellations(grid, reach, codes, bases)
    bits = max(int(np.ceil(np.log2(max(total, 2)))), 1)
    starts = np.zeros((1 << bits) + 1, dtype=np.uint32)
    order = _sort_into_buckets(codes, bits, starts)
    codes, bases = codes[order], bases[order]
    for array in (codes, bases, starts):
        array.flags.writeable = False
    return ConstellationIndex(codes, bases, starts, bits, reach)


def _choose_reach(grid: DotGrid) -> float:
    """Return the base length [m] up to which a sample of the map has the wanted number of constellations."""
    step = max(len(grid.points) // _SAMPLE, 1)
    sample = len(range(0, len(grid.points), step))
    widest = 2.6 * grid.cell
    counts = np.zeros(len(grid.points), dtype=np.int64)
    histogram = np.zeros(256)
    _count_constellations(grid, widest, step, counts, histogram)
    enough = np.searchsorted(np.cumsum(histogram), CONSTELLATIONS_PER_DOT * sample)
    return float(widest * min(enough + 1, 256) / 256.0)


@njit(cache=True)
def _count_constellations(
    grid: DotGrid, reach: float, step: int, counts: NDArray[np.int64], histogram: NDArray[np.float64]
) -> None:
    """Count the constellations whose base begins at each ``step``-th dot, and by base length when asked."""
    near = np.empty(_NEIGHBOURS, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    for first in range(0, len(grid.points), step):
        count = dots_within(grid, grid.points[first, 0], grid.points[first, 1], reach, near)
        for second in near[:count]:
            if second <= first:
                continue
            length = distance(grid.points, first, second)
            found = groups_on_base(grid.points, first, second, near[:count], length, groups)
            counts[first] += found
            if len(histogram) > 0:
                histogram[min(int(length / reach * len(histogram)), len(histogram) - 1)] += found


@njit(cache=True)
def _list_constellations(
    grid: DotGrid, reach: float, codes: NDArray[np.uint64], bases: NDArray[np.uint32]
) -> None:
    """Write the key and the base of every constellation of the map."""
    near = np.empty(_NEIGHBOURS, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    listed = 0
    for first in range(len(grid.points)):
        count = dots_within(grid, grid.points[first, 0], grid.points[first, 1], reach, near)
        for second in near[:count]:
            if second <= first:
                continue
            length = distance(grid.points, first, second)
            found = groups_on_base(grid.points, first, second, near[:count], length, groups)
            for g in range(found):
                _write_constellation(grid.points, first, second, groups[g], codes, bases, listed)
                listed += 1


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
