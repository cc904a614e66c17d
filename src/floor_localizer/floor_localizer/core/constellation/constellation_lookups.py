"""Cells of the index that may contain a constellation of a view, the most likely ones first.

Noise moves a coordinate of a key out of its cell with a probability that depends on its distance to the nearest cell
border. The home cell and its neighbours are opened in the order of their probability: the most likely cell of every
constellation costs less and finds more than all cells of a few constellations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.constellation_key import (
    LANE_HASHES,
    LANES,
    LOWER,
    OTHERS,
    PARTS,
    bucket_of_hash,
    from_steps,
    imbalance,
    part_of_lane,
    turn_around,
)

# Gate: maximum error of a coordinate of a key [standard deviations].
_LANE_GATE = 2.6
# The logistic function with this slope approximates the normal distribution to 0.01.
_SLOPE = 1.702
_ROOM, _CELL_ROOM = 32, 1024


class Lookups(NamedTuple):
    """A batch of constellations and the buckets to open for them: batched, so that memory is read in parallel.

    Attributes:
        seeds: shape (q, 6), view dots of each constellation, baseline first, inner dots in the order of the key.
        xy: shape (q, 4, 2), coordinates of its inner dots [baseline lengths].
        noise: shape (q,), standard deviation of a dot's position [baseline lengths].
        cells: shape (q, 8, 2), home cell and nearest neighbour cell along each coordinate.
        compatible: shape (q, 8, 2) uint8, bit mask for each of these cells: steps of the cell within the gate.
        buckets: shape (c,), buckets to open.
        owners: shape (c,), index of the constellation of each bucket.
        neighbour_bits: shape (c,), bit mask: coordinates along which the cell is the neighbour, not the home cell.
        counts: shape (2,), number of constellations and of buckets.
    """

    seeds: NDArray[np.int64]
    xy: NDArray[np.float64]
    noise: NDArray[np.float64]
    cells: NDArray[np.int64]
    fitting: NDArray[np.uint8]
    buckets: NDArray[np.int64]
    owners: NDArray[np.int64]
    beyond: NDArray[np.int64]
    counts: NDArray[np.int64]


class Wanted(NamedTuple):
    """Range of probability of the cells to open.

    Attributes:
        minimum: lower end, included.
        maximum: upper end, excluded.
    """

    least: float
    below: float


@njit(cache=True)
def no_lookups() -> Lookups:
    """Return an empty batch of lookups."""
    return Lookups(
        np.empty((_ROOM, 2 + OTHERS), dtype=np.int64),
        np.empty((_ROOM, OTHERS, 2)),
        np.empty(_ROOM),
        np.empty((_ROOM, LANES, 2), dtype=np.int64),
        np.empty((_ROOM, LANES, 2), dtype=np.uint8),
        np.empty(_CELL_ROOM, dtype=np.int64),
        np.empty(_CELL_ROOM, dtype=np.int64),
        np.empty(_CELL_ROOM, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
    )


@njit(cache=True)
def is_full(lookups: Lookups) -> bool:
    """Return whether the batch may not hold the ten permutations of one more constellation."""
    return lookups.counts[0] > _ROOM - 10 or lookups.counts[1] > _CELL_ROOM // 2


@njit(cache=True)
def add_constellation(
    index: ConstellationIndex,
    lookups: Lookups,
    seeds: NDArray[np.int64],
    xy: NDArray[np.float64],
    noise: float,
    wanted: Wanted,
) -> None:
    """Add the cells of a constellation in a range of probability, with both orders of its ends and x-neighbours.

    Args:
        index: the map's constellations.
        lookups: the batch so far; extended.
        seeds: shape (6,), view dots of the constellation, the baseline first.
        xy: shape (4, 2), coordinates of the inner dots; overwritten.
        noise: standard deviation of a dot's position [baseline lengths].
        probability_range: range of probability of the cells to add.
    """
    for side in range(2):
        if side == 1:
            turn_around(xy)
        # Noise of the mean of four coordinates: a quarter of a dot's variance and that of half of each end.
        likely = _logistic(-imbalance(xy) / (0.87 * noise))
        if likely < wanted.least:
            continue
        one = lookups.counts[0]
        lookups.seeds[one, 0], lookups.seeds[one, 1] = seeds[side], seeds[1 - side]
        _sort(xy, lookups.xy[one], seeds[2:], lookups.seeds[one, 2:])
        base, ordered = lookups.seeds[one].copy(), lookups.xy[one].copy()
        _add_form(index, lookups, base, ordered, noise, likely, wanted)
        for k in range(OTHERS - 1):
            swapped = likely * _logistic(-(ordered[k + 1, 0] - ordered[k, 0]) / (1.41 * noise))
            if swapped >= wanted.least:
                _swap(base, ordered, k)
                _add_form(index, lookups, base, ordered, noise, swapped, wanted)
                _swap(base, ordered, k)


@njit(cache=True)
def _logistic(deviations: float) -> float:
    return 1.0 / (1.0 + math.exp(-_SLOPE * deviations))


@njit(cache=True)
def _sort(
    xy: NDArray[np.float64],
    sorted_xy: NDArray[np.float64],
    dots: NDArray[np.int64],
    sorted_dots: NDArray[np.int64],
) -> None:
    """Write coordinates, shape (4, 2), and dots, shape (4,), sorted by x."""
    for k in range(OTHERS):
        m = k
        while m > 0 and sorted_xy[m - 1, 0] > xy[k, 0]:
            sorted_xy[m, 0], sorted_xy[m, 1] = sorted_xy[m - 1, 0], sorted_xy[m - 1, 1]
            sorted_dots[m] = sorted_dots[m - 1]
            m -= 1
        sorted_xy[m, 0], sorted_xy[m, 1] = xy[k, 0], xy[k, 1]
        sorted_dots[m] = dots[k]


@njit(cache=True)
def _swap(seeds: NDArray[np.int64], xy: NDArray[np.float64], k: int) -> None:
    """Swap two neighbours in the order of the key."""
    seeds[2 + k], seeds[3 + k] = seeds[3 + k], seeds[2 + k]
    for axis in range(2):
        xy[k, axis], xy[k + 1, axis] = xy[k + 1, axis], xy[k, axis]


@njit(cache=True)
def _add_form(
    index: ConstellationIndex,
    lookups: Lookups,
    seeds: NDArray[np.int64],
    xy: NDArray[np.float64],
    noise: float,
    likely: float,
    wanted: Wanted,
) -> None:
    """Add the cells of a constellation for one permutation of its dots, which is right with some probability."""
    odds = np.empty(LANES)
    hashes = np.empty(LANES, dtype=np.uint64)
    one = lookups.counts[0]
    mixed = np.uint64(0)
    for k in range(LANES):
        home, away, odds[k] = _home(xy[k >> 1, k & 1], LOWER[k & 1], index.step, _spread(xy[k >> 1], noise))
        lookups.cells[one, k, 0], lookups.cells[one, k, 1] = home, away
        mixed += np.uint64(home) * LANE_HASHES[k]
        hashes[k] = LANE_HASHES[k] if away > home else np.uint64(0) - LANE_HASHES[k]
        likely /= 1.0 + odds[k]
    if likely < wanted.least:
        return
    before = lookups.counts[1]
    _add_cells(index, lookups, mixed, likely, odds, hashes, wanted)
    if lookups.counts[1] == before:
        return
    lookups.counts[0] = one + 1
    lookups.seeds[one, 0], lookups.seeds[one, 1], lookups.noise[one] = seeds[0], seeds[1], noise
    for k in range(OTHERS):
        lookups.seeds[one, 2 + k] = seeds[2 + k]
        lookups.xy[one, k, 0], lookups.xy[one, k, 1] = xy[k, 0], xy[k, 1]
    for k in range(LANES):
        reach = _LANE_GATE * _spread(xy[k >> 1], noise)
        for side in range(2):
            lookups.fitting[one, k, side] = _fitting_parts(
                lookups.cells[one, k, side], xy[k >> 1, k & 1], reach, LOWER[k & 1], index.step
            )


@njit(cache=True)
def _spread(dot: NDArray[np.float64], noise: float) -> float:
    """Return the standard deviation of a coordinate from the noise of the dot and of the baseline's ends."""
    x, y = dot[0], dot[1]
    return noise * math.sqrt(1.0 + x * x + (1.0 - x) * (1.0 - x) + 2.0 * y * y)


@njit(cache=True)
def _home(value: float, lower: float, step: float, spread: float) -> tuple[int, int, float]:
    """Return the home cell of a coordinate, the nearest neighbour cell, and the odds that noise moved it from there."""
    side = PARTS * step
    place = max((value - lower) / side, 0.0)
    home = int(place)
    left = place - home
    away = home + 1 if left > 0.5 else home - 1
    return home, away, math.exp(-_SLOPE * min(left, 1.0 - left) * side / spread)


@njit(cache=True)
def _fitting_parts(cell: int, value: float, reach: float, lower: float, step: float) -> int:
    """Return a bit mask of the steps of a cell that are within the tolerance of a coordinate."""
    fitting = 0
    for part in range(PARTS):
        if abs(from_steps(cell * PARTS + part, lower, step) - value) <= reach + 0.5 * step:
            fitting |= 1 << part
    return fitting


@njit(cache=True)
def fits(lookups: Lookups, lookup: int, parts: np.uint64) -> bool:
    """Return whether a key of an opened cell is within the gate along all coordinates.

    Args:
        lookups: the batch.
        lookup: index of the opened cell.
        subcell: subcell of the key, from `pack_subcell`.
    """
    owner, beyond = lookups.owners[lookup], lookups.beyond[lookup]
    for k in range(LANES):  # noqa: SIM110 - numba compiles no all() over a generator
        if not (lookups.fitting[owner, k, (beyond >> k) & 1] >> part_of_lane(parts, k)) & 1:
            return False
    return True


@njit(cache=True)
def key_coordinates(
    lookups: Lookups, lookup: int, parts: np.uint64, step: float, xy: NDArray[np.float64]
) -> None:
    """Write the coordinates of a key of an opened cell to ``xy``, shape (4, 2); arguments as for `is_compatible`."""
    owner, beyond = lookups.owners[lookup], lookups.beyond[lookup]
    for k in range(LANES):
        cell = lookups.cells[owner, k, (beyond >> k) & 1]
        xy[k >> 1, k & 1] = from_steps(cell * PARTS + part_of_lane(parts, k), LOWER[k & 1], step)


@njit(cache=True)
def _add_cells(
    index: ConstellationIndex,
    lookups: Lookups,
    mixed: np.uint64,
    likely: float,
    odds: NDArray[np.float64],
    steps: NDArray[np.uint64],
    wanted: Wanted,
) -> None:
    """Add the home cell and its neighbours along any coordinates, if they are likely enough."""
    hashes = np.empty(1 << LANES, dtype=np.uint64)
    shares = np.empty(1 << LANES)
    beyond = np.zeros(1 << LANES, dtype=np.int64)
    hashes[0], shares[0] = mixed, likely
    count = 1
    for k in range(LANES):
        # At least half of the coordinates are far from a border.
        if likely * odds[k] < wanted.least:
            continue
        for c in range(count):
            share = shares[c] * odds[k]
            if share >= wanted.least:
                hashes[count], shares[count], beyond[count] = hashes[c] + steps[k], share, beyond[c] | 1 << k
                count += 1
    for c in range(count):
        one = lookups.counts[1]
        if shares[c] < wanted.below and one < len(lookups.buckets):
            lookups.buckets[one] = bucket_of_hash(hashes[c], len(index.starts) - 1)
            lookups.owners[one] = lookups.counts[0]
            lookups.beyond[one] = beyond[c]
            lookups.counts[1] += 1
