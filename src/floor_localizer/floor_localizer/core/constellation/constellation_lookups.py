"""Cells of the index that may contain a constellation of a view, the most likely ones first.

Noise moves a coordinate of a key out of its cell with a probability that depends on its distance to the nearest cell
border. The home cell and its neighbours are opened in the order of their probability: the most likely cell of every
constellation costs less and finds more than all cells of a few constellations.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Floats, Ints, Pixels
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.constellation_key import (
    COORDINATE_HASHES,
    INNER_DOTS,
    KEY_SIZE,
    LOWER,
    STEPS_PER_CELL,
    bucket_of_hash,
    dequantize,
    mean_x_offset,
    subcell_step,
    swap_ends,
)

# Gate: maximum error of a coordinate of a key [standard deviations].
_COORDINATE_GATE = 2.6
# The logistic function with this slope approximates the normal distribution to 0.01.
_LOGISTIC_SLOPE = 1.702
_CAPACITY, _CELL_CAPACITY = 32, 1024


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

    seeds: Ints
    xy: Floats
    noise: Floats
    cells: Ints
    compatible: Pixels
    buckets: Ints
    owners: Ints
    neighbour_bits: Ints
    counts: Ints


class ProbabilityRange(NamedTuple):
    """Range of probability of the cells to open: ``minimum`` is included, ``maximum`` is not."""

    minimum: float
    maximum: float


@njit(cache=True)
def allocate_lookups() -> Lookups:
    """Return an empty batch of lookups."""
    return Lookups(
        np.empty((_CAPACITY, 2 + INNER_DOTS), dtype=np.int64),
        np.empty((_CAPACITY, INNER_DOTS, 2)),
        np.empty(_CAPACITY),
        np.empty((_CAPACITY, KEY_SIZE, 2), dtype=np.int64),
        np.empty((_CAPACITY, KEY_SIZE, 2), dtype=np.uint8),
        np.empty(_CELL_CAPACITY, dtype=np.int64),
        np.empty(_CELL_CAPACITY, dtype=np.int64),
        np.empty(_CELL_CAPACITY, dtype=np.int64),
        np.zeros(2, dtype=np.int64),
    )


@njit(cache=True)
def is_full(lookups: Lookups) -> bool:
    """Return whether the batch may not hold the ten permutations of one more constellation."""
    return lookups.counts[0] > _CAPACITY - 10 or lookups.counts[1] > _CELL_CAPACITY // 2


@njit(cache=True)
def add_constellation(
    index: ConstellationIndex,
    lookups: Lookups,
    seeds: Ints,
    xy: Floats,
    noise: float,
    probability_range: ProbabilityRange,
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
            swap_ends(xy)
        # Noise of the mean of four coordinates: a quarter of a dot's variance and that of half of each end.
        probability = _logistic(-mean_x_offset(xy) / (0.87 * noise))
        if probability < probability_range.minimum:
            continue
        slot = lookups.counts[0]
        lookups.seeds[slot, 0], lookups.seeds[slot, 1] = seeds[side], seeds[1 - side]
        _sort_by_x(xy, lookups.xy[slot], seeds[2:], lookups.seeds[slot, 2:])
        permuted_seeds, permuted_xy = lookups.seeds[slot].copy(), lookups.xy[slot].copy()
        _add_permutation(index, lookups, permuted_seeds, permuted_xy, noise, probability, probability_range)
        for k in range(INNER_DOTS - 1):
            swapped = probability * _logistic(-(permuted_xy[k + 1, 0] - permuted_xy[k, 0]) / (1.41 * noise))
            if swapped >= probability_range.minimum:
                _swap(permuted_seeds, permuted_xy, k)
                _add_permutation(index, lookups, permuted_seeds, permuted_xy, noise, swapped, probability_range)
                _swap(permuted_seeds, permuted_xy, k)


@njit(cache=True)
def _logistic(deviations: float) -> float:
    return 1.0 / (1.0 + math.exp(-_LOGISTIC_SLOPE * deviations))


@njit(cache=True)
def _sort_by_x(xy: Floats, sorted_xy: Floats, dots: Ints, sorted_dots: Ints) -> None:
    """Write coordinates, shape (4, 2), and dots, shape (4,), sorted by x."""
    for k in range(INNER_DOTS):
        m = k
        while m > 0 and sorted_xy[m - 1, 0] > xy[k, 0]:
            sorted_xy[m, 0], sorted_xy[m, 1] = sorted_xy[m - 1, 0], sorted_xy[m - 1, 1]
            sorted_dots[m] = sorted_dots[m - 1]
            m -= 1
        sorted_xy[m, 0], sorted_xy[m, 1] = xy[k, 0], xy[k, 1]
        sorted_dots[m] = dots[k]


@njit(cache=True)
def _swap(seeds: Ints, xy: Floats, k: int) -> None:
    """Swap two neighbours in the order of the key."""
    seeds[2 + k], seeds[3 + k] = seeds[3 + k], seeds[2 + k]
    for axis in range(2):
        xy[k, axis], xy[k + 1, axis] = xy[k + 1, axis], xy[k, axis]


@njit(cache=True)
def _add_permutation(
    index: ConstellationIndex,
    lookups: Lookups,
    seeds: Ints,
    xy: Floats,
    noise: float,
    probability: float,
    probability_range: ProbabilityRange,
) -> None:
    """Add the cells of a constellation for one permutation of its dots, which is right with some probability."""
    odds = np.empty(KEY_SIZE)
    hashes = np.empty(KEY_SIZE, dtype=np.uint64)
    slot = lookups.counts[0]
    cell_hash = np.uint64(0)
    for k in range(KEY_SIZE):
        home, neighbour, odds[k] = _home_cell(
            xy[k >> 1, k & 1], LOWER[k & 1], index.step, _coordinate_sigma(xy[k >> 1], noise)
        )
        lookups.cells[slot, k, 0], lookups.cells[slot, k, 1] = home, neighbour
        cell_hash += np.uint64(home) * COORDINATE_HASHES[k]
        hashes[k] = COORDINATE_HASHES[k] if neighbour > home else np.uint64(0) - COORDINATE_HASHES[k]
        probability /= 1.0 + odds[k]
    if probability < probability_range.minimum:
        return
    before = lookups.counts[1]
    _add_cells(index, lookups, cell_hash, probability, odds, hashes, probability_range)
    if lookups.counts[1] == before:
        return
    lookups.counts[0] = slot + 1
    lookups.seeds[slot, 0], lookups.seeds[slot, 1], lookups.noise[slot] = seeds[0], seeds[1], noise
    for k in range(INNER_DOTS):
        lookups.seeds[slot, 2 + k] = seeds[2 + k]
        lookups.xy[slot, k, 0], lookups.xy[slot, k, 1] = xy[k, 0], xy[k, 1]
    for k in range(KEY_SIZE):
        tolerance = _COORDINATE_GATE * _coordinate_sigma(xy[k >> 1], noise)
        for side in range(2):
            lookups.compatible[slot, k, side] = _compatible_steps(
                lookups.cells[slot, k, side], xy[k >> 1, k & 1], tolerance, LOWER[k & 1], index.step
            )


@njit(cache=True)
def _coordinate_sigma(dot: Floats, noise: float) -> float:
    """Return the standard deviation of a coordinate from the noise of the dot and of the baseline's ends."""
    x, y = dot[0], dot[1]
    return noise * math.sqrt(1.0 + x * x + (1.0 - x) * (1.0 - x) + 2.0 * y * y)


@njit(cache=True)
def _home_cell(value: float, lower: float, step: float, sigma: float) -> tuple[int, int, float]:
    """Return the home cell of a coordinate, the nearest neighbour cell, and the odds that noise moved it from there."""
    side = STEPS_PER_CELL * step
    place = max((value - lower) / side, 0.0)
    home = int(place)
    fraction = place - home
    neighbour = home + 1 if fraction > 0.5 else home - 1
    return home, neighbour, math.exp(-_LOGISTIC_SLOPE * min(fraction, 1.0 - fraction) * side / sigma)


@njit(cache=True)
def _compatible_steps(cell: int, value: float, tolerance: float, lower: float, step: float) -> int:
    """Return a bit mask of the steps of a cell that are within the tolerance of a coordinate."""
    compatible = 0
    for substep in range(STEPS_PER_CELL):
        if abs(dequantize(cell * STEPS_PER_CELL + substep, lower, step) - value) <= tolerance + 0.5 * step:
            compatible |= 1 << substep
    return compatible


@njit(cache=True)
def is_compatible(lookups: Lookups, lookup: int, subcell: np.uint64) -> bool:
    """Return whether a key, by its subcell, of the opened cell ``lookup`` is within the gate along all coordinates."""
    owner, neighbour_bits = lookups.owners[lookup], lookups.neighbour_bits[lookup]
    for k in range(KEY_SIZE):
        if not (lookups.compatible[owner, k, (neighbour_bits >> k) & 1] >> subcell_step(subcell, k)) & 1:
            return False
    return True


@njit(cache=True)
def key_coordinates(lookups: Lookups, lookup: int, subcell: np.uint64, step: float, xy: Floats) -> None:
    """Write the coordinates of a key of an opened cell to ``xy``, shape (4, 2); arguments as for `is_compatible`."""
    owner, neighbour_bits = lookups.owners[lookup], lookups.neighbour_bits[lookup]
    for k in range(KEY_SIZE):
        cell = lookups.cells[owner, k, (neighbour_bits >> k) & 1]
        xy[k >> 1, k & 1] = dequantize(cell * STEPS_PER_CELL + subcell_step(subcell, k), LOWER[k & 1], step)


@njit(cache=True)
def _add_cells(
    index: ConstellationIndex,
    lookups: Lookups,
    cell_hash: np.uint64,
    probability: float,
    odds: Floats,
    hash_steps: NDArray[np.uint64],
    probability_range: ProbabilityRange,
) -> None:
    """Add the home cell and its neighbours along any coordinates, if they are likely enough."""
    hashes = np.empty(1 << KEY_SIZE, dtype=np.uint64)
    cell_probabilities = np.empty(1 << KEY_SIZE)
    neighbour_bits = np.zeros(1 << KEY_SIZE, dtype=np.int64)
    hashes[0], cell_probabilities[0] = cell_hash, probability
    count = 1
    for k in range(KEY_SIZE):
        # At least half of the coordinates are far from a border.
        if probability * odds[k] < probability_range.minimum:
            continue
        for c in range(count):
            cell_probability = cell_probabilities[c] * odds[k]
            if cell_probability >= probability_range.minimum:
                hashes[count], cell_probabilities[count] = hashes[c] + hash_steps[k], cell_probability
                neighbour_bits[count] = neighbour_bits[c] | 1 << k
                count += 1
    for c in range(count):
        slot = lookups.counts[1]
        if cell_probabilities[c] < probability_range.maximum and slot < len(lookups.buckets):
            lookups.buckets[slot] = bucket_of_hash(hashes[c], len(index.starts) - 1)
            lookups.owners[slot] = lookups.counts[0]
            lookups.neighbour_bits[slot] = neighbour_bits[c]
            lookups.counts[1] += 1
