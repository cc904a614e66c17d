"""The index: every small constellation of six map dots, sorted by its key."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import (
    OTHERS,
    base_coordinates,
    bucket_of_hash,
    cell_sides,
    hash_of_code,
    imbalance,
    lane_hashes,
    pack_coordinates,
    sort_by_x,
    turn_around,
)
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.lens import MOST_GROUPS, groups_of_four

# A base is indexed when at most this many dots are in its lens.
MOST_INDEXED = 6
# Longest base in units of the mean spacing of dots.
_WIDEST = 3.0
_NEIGHBOURS = 64
# Room for so many constellations a dot is made at first.
_ROOM = 18
_KEYS_PER_BUCKET = 4.0


class ConstellationIndex(NamedTuple):
    """Constellations of six dots by their key; the arrays may be memory-mapped.

    Attributes:
        codes: shape (M,) uint64, the packed key of each constellation, bucket by bucket.
        bases: shape (M, 2) uint32, its base: the grid's indices of the dots at (0, 0) and (1, 0).
        starts: shape (2**bits + 1,) uint32, where each bucket begins.
        bits: number of bits of a bucket's number.
        x_cell: side of a hash cell along x in steps of a key.
        y_cell: the same along y.
        reach: the longest base [m].
    """

    codes: NDArray[np.uint64]
    bases: NDArray[np.uint32]
    starts: NDArray[np.uint32]
    bits: int
    x_cell: int
    y_cell: int
    reach: float


class Surroundings(NamedTuple):
    """A dot and those around it.

    Attributes:
        dots: shape (64,), indices in the grid.
        points: shape (64, 2), from the first dot [m].
        squared: shape (64,), squared distances from it [m^2].
    """

    dots: NDArray[np.int64]
    points: NDArray[np.float64]
    squared: NDArray[np.float64]


def build_constellation_index(grid: DotGrid) -> ConstellationIndex:
    """Index the smallest constellations around every dot, about sixteen each.

    Few large constellations tell places apart as well as many small ones, and sixteen a dot leave some whole when half
    of the dots are missing. The size follows the density around each dot, so sparse places are indexed like dense ones.
    """
    codes, bases, reach = _list_constellations(grid, _WIDEST * grid.cell)
    bits = max(math.ceil(math.log2(max(len(codes) / _KEYS_PER_BUCKET, 2.0))), 1)
    index = ConstellationIndex(
        np.empty_like(codes),
        np.empty_like(bases),
        np.zeros((1 << bits) + 1, dtype=np.uint32),
        bits,
        *cell_sides(len(codes)),
        reach,
    )
    _fill_buckets(codes, bases, index)
    for array in (index.codes, index.bases, index.starts):
        array.flags.writeable = False
    return index


@njit(cache=True)
def _list_constellations(
    grid: DotGrid, widest: float
) -> tuple[NDArray[np.uint64], NDArray[np.uint32], float]:
    """List the constellations of all dots with bases no longer than ``widest`` [m].

    Returns:
        their keys, shape (M,), their bases, shape (M, 2), and the longest base [m].
    """
    around = Surroundings(
        np.empty(_NEIGHBOURS, dtype=np.int64), np.zeros((_NEIGHBOURS, 2)), np.zeros(_NEIGHBOURS)
    )
    lens = np.empty(MOST_INDEXED + 1, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    xy = np.empty((OTHERS, 2))
    codes = np.empty(_ROOM * len(grid.points) + MOST_GROUPS, dtype=np.uint64)
    bases = np.empty((len(codes), 2), dtype=np.uint32)
    total, reach = 0, 0.0
    for first in range(len(grid.points)):
        count = _look_around(grid, first, widest, around)
        for second in range(OTHERS + 1, count):
            if around.dots[second] <= first:
                continue
            inside = _dots_in_lens(around, second, lens)
            if inside < OTHERS or inside > MOST_INDEXED:
                continue
            length = math.sqrt(around.squared[second])
            found = groups_of_four(around.points, lens[:inside], length, groups)
            if total + found > len(codes):
                codes = np.concatenate((codes, np.empty_like(codes)))
                bases = np.concatenate((bases, np.empty_like(bases)))
            for g in range(found):
                codes[total], swapped = _key(around.points, second, groups[g], xy)
                bases[total, swapped], bases[total, 1 - swapped] = first, around.dots[second]
                total += 1
            if found > 0:
                reach = max(reach, length)
    return codes[:total], bases[:total], reach


@njit(cache=True)
def _fill_buckets(codes: NDArray[np.uint64], bases: NDArray[np.uint32], index: ConstellationIndex) -> None:
    """Write keys and bases to the index bucket by bucket (a counting sort)."""
    table = lane_hashes(index.x_cell, index.y_cell)
    # The bucket of a key counts one place ahead: filling it moves its beginning to its end, where the next one begins.
    begins = index.starts[1:]
    for code in codes:
        begins[bucket_of_hash(hash_of_code(code, table), index.bits)] += np.uint32(1)
    total = np.uint32(0)
    for bucket in range(len(begins)):
        count = begins[bucket]
        begins[bucket] = total
        total += count
    for i in range(len(codes)):
        bucket = bucket_of_hash(hash_of_code(codes[i], table), index.bits)
        entry = begins[bucket]
        begins[bucket] = entry + np.uint32(1)
        index.codes[entry] = codes[i]
        index.bases[entry, 0], index.bases[entry, 1] = bases[i, 0], bases[i, 1]


@njit(cache=True)
def _look_around(grid: DotGrid, first: int, widest: float, around: Surroundings) -> int:
    """Write the dots around one, itself first and the others from near to far, and return their number."""
    x, y = np.float64(grid.points[first, 0]), np.float64(grid.points[first, 1])
    count = dots_within(grid, x, y, widest, around.dots)
    near = around.dots[:count].copy()
    around.dots[0] = first
    filled = 1
    for dot in near:
        if dot == first:
            continue
        dx, dy = np.float64(grid.points[dot, 0]) - x, np.float64(grid.points[dot, 1]) - y
        squared = dx * dx + dy * dy
        k = filled
        while k > 1 and around.squared[k - 1] > squared:
            around.dots[k], around.squared[k] = around.dots[k - 1], around.squared[k - 1]
            around.points[k, 0], around.points[k, 1] = around.points[k - 1, 0], around.points[k - 1, 1]
            k -= 1
        around.dots[k], around.squared[k] = dot, squared
        around.points[k, 0], around.points[k, 1] = dx, dy
        filled += 1
    return filled


@njit(cache=True)
def _dots_in_lens(around: Surroundings, second: int, lens: NDArray[np.int64]) -> int:
    """Write the dots in the lens of the base from the middle dot to ``second``, and return their number.

    As the dots are in order, only those before the second are near enough to the first. One more than may be
    indexed is enough to know.
    """
    x, y = around.points[second, 0], around.points[second, 1]
    found = 0
    for k in range(1, second):
        dx, dy = around.points[k, 0] - x, around.points[k, 1] - y
        if dx * dx + dy * dy <= around.squared[second]:
            lens[found] = k
            found += 1
            if found == len(lens):
                break
    return found


@njit(cache=True)
def _key(
    points: NDArray[np.float64], second: int, others: NDArray[np.int64], xy: NDArray[np.float64]
) -> tuple[np.uint64, int]:
    """Return the key of one constellation with its ends so that the others are more on the first one's side.

    Args:
        points: shape (n, 2), dots [m]; the first is one end of the base.
        second: the other end.
        others: shape (4,), the other dots.
        xy: shape (4, 2), room to work in.

    Returns:
        the key, and 1 if the ends changed places in it.
    """
    base_coordinates(points, np.int64(0), second, others, xy)
    swapped = 1 if imbalance(xy) > 0.0 else 0
    if swapped:
        turn_around(xy)
    sort_by_x(xy)
    return pack_coordinates(xy), swapped
