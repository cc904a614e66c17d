"""Which cells of the index a constellation of a view may be in, the likely ones first.

Noise moves a coordinate of a key out of its cell with a probability that follows from its distance to the nearest
border. The cell at home and those across one or more borders are opened in the order of their probability: a look into
the likeliest cell of every constellation costs less and finds more than a look into all cells of a few.
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
    OTHERS,
    X_LOWER,
    X_STEPS,
    Y_LOWER,
    Y_STEPS,
    bucket_of_hash,
    imbalance,
    pack_coordinates,
    turn_around,
)

# A coordinate of a key may be off by this many standard deviations.
_LANE_GATE = 2.6
# The logistic curve of this slope is the normal distribution to a hundredth.
_SLOPE = 1.702
_ROOM, _CELL_ROOM = 32, 1024
_LANE_STEPS = np.array([X_STEPS, Y_STEPS] * OTHERS)


class Lookups(NamedTuple):
    """Constellations and the buckets that are to be opened for them: together, so that memory is read in parallel.

    Attributes:
        seeds: shape (q, 6), the view dots of each constellation, base first, the others in the order of the key.
        xy: shape (q, 4, 2), the coordinates of its others.
        noise: shape (q,), standard deviation of a dot's place in units of its base's length.
        lower: shape (q,) uint64, the least steps of a key that fits, packed.
        upper: shape (q,) uint64, the largest.
        buckets: shape (c,), buckets to open.
        owners: shape (c,), the constellation that each is opened for.
        counts: shape (2,), number of constellations and of buckets.
    """

    seeds: NDArray[np.int64]
    xy: NDArray[np.float64]
    noise: NDArray[np.float64]
    lower: NDArray[np.uint64]
    upper: NDArray[np.uint64]
    buckets: NDArray[np.int64]
    owners: NDArray[np.int64]
    counts: NDArray[np.int64]


class Wanted(NamedTuple):
    """Which cells are wanted: those with a probability in a range.

    Attributes:
        least: the lower end, included.
        below: the upper end, excluded.
    """

    least: float
    below: float


@njit(cache=True)
def no_lookups() -> Lookups:
    """Return room for lookups, with none in it."""
    return Lookups(
        np.empty((_ROOM, 2 + OTHERS), dtype=np.int64),
        np.empty((_ROOM, OTHERS, 2)),
        np.empty(_ROOM),
        np.empty(_ROOM, dtype=np.uint64),
        np.empty(_ROOM, dtype=np.uint64),
        np.empty(_CELL_ROOM, dtype=np.int64),
        np.empty(_CELL_ROOM, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
    )


@njit(cache=True)
def is_full(lookups: Lookups) -> bool:
    """Tell whether there may be no room for the ten forms of one more constellation."""
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
    """Add the wanted cells of a constellation, with either end first and neighbours along x in either order.

    Args:
        index: the map's constellations.
        lookups: what there is to look up already.
        seeds: shape (6,), its view dots, the base first.
        xy: shape (4, 2), the coordinates of the others; overwritten.
        noise: standard deviation of a dot's place in units of the base's length.
        wanted: which cells.
    """
    for side in range(2):
        if side == 1:
            turn_around(xy)
        # The mean of four coordinates has the noise of a quarter of a dot and of half of either end.
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
    """Write coordinates, shape (4, 2), and dots, shape (4,), in order of their x."""
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
    """Exchange two neighbours in the order of the key."""
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
    """Add the wanted cells of a constellation in one order of its dots, which is right with some probability."""
    odds = np.empty(LANES)
    steps = np.empty(LANES, dtype=np.uint64)
    mixed = np.uint64(0)
    for k in range(LANES):
        x, y = xy[k >> 1, 0], xy[k >> 1, 1]
        # A dot's own noise and its share of that of the base's ends.
        spread = noise * math.sqrt(1.0 + x * x + (1.0 - x) * (1.0 - x) + 2.0 * y * y)
        if k % 2 == 0:
            cell, odds[k], steps[k] = _home(x, X_LOWER, X_STEPS, spread, index.x_cell, LANE_HASHES[k])
        else:
            cell, odds[k], steps[k] = _home(y, Y_LOWER, Y_STEPS, spread, index.y_cell, LANE_HASHES[k])
        mixed += np.uint64(cell) * LANE_HASHES[k]
        likely /= 1.0 + odds[k]
    if likely < wanted.least:
        return
    before = lookups.counts[1]
    _add_cells(index, lookups, mixed, likely, odds, steps, wanted)
    if lookups.counts[1] == before:
        return
    one = lookups.counts[0]
    lookups.counts[0] = one + 1
    lookups.seeds[one, 0], lookups.seeds[one, 1], lookups.noise[one] = seeds[0], seeds[1], noise
    lower, upper = np.empty((OTHERS, 2)), np.empty((OTHERS, 2))
    for k in range(OTHERS):
        x, y = xy[k, 0], xy[k, 1]
        lookups.seeds[one, 2 + k] = seeds[2 + k]
        lookups.xy[one, k, 0], lookups.xy[one, k, 1] = x, y
        reach = _LANE_GATE * noise * math.sqrt(1.0 + x * x + (1.0 - x) * (1.0 - x) + 2.0 * y * y)
        lower[k, 0], lower[k, 1], upper[k, 0], upper[k, 1] = x - reach, y - reach, x + reach, y + reach
    lookups.lower[one] = pack_coordinates(lower)
    lookups.upper[one] = pack_coordinates(upper)


@njit(cache=True)
def _home(
    value: float, lower: float, steps: float, spread: float, side: int, lane_hash: np.uint64
) -> tuple[int, float, np.uint64]:
    """Return the cell of a coordinate, the odds that noise moved it out of the next one, and that one's hash
    less its own.
    """
    place = min(max((value - lower) * steps + 0.5, 0.0), 127.0)
    cell = int(place) // side
    left = place - cell * side
    right = side - left
    odds = math.exp(-_SLOPE * min(left, right) / (spread * steps))
    return cell, odds, lane_hash if right < left else np.uint64(0) - lane_hash


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
    """Add the cell at home and those next to it along any lanes, if they are likely enough."""
    hashes = np.empty(1 << LANES, dtype=np.uint64)
    shares = np.empty(1 << LANES)
    hashes[0], shares[0] = mixed, likely
    count = 1
    for k in range(LANES):
        # Half of the lanes at least are far from a border.
        if likely * odds[k] < wanted.least:
            continue
        for c in range(count):
            share = shares[c] * odds[k]
            if share >= wanted.least:
                hashes[count], shares[count] = hashes[c] + steps[k], share
                count += 1
    for c in range(count):
        if shares[c] < wanted.below and lookups.counts[1] < len(lookups.buckets):
            lookups.buckets[lookups.counts[1]] = bucket_of_hash(hashes[c], index.bits)
            lookups.owners[lookups.counts[1]] = lookups.counts[0]
            lookups.counts[1] += 1
