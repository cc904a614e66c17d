"""Look the constellations of a view up in the index until one grows to a pose that cannot be chance."""

from __future__ import annotations

import itertools

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import ViewDots, grow
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.constellation_key import (
    LANES,
    OTHERS,
    X_CELL,
    X_LOWER,
    X_STEPS,
    Y_CELL,
    Y_LOWER,
    Y_STEPS,
    base_coordinates,
    bucket_of_cells,
    imbalance,
    is_within,
    pack,
    to_steps,
    turn_around,
)
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.lens import (
    MOST_GROUPS,
    MOST_IN_LENS,
    distance,
    dots_in_lens,
    groups_of_four,
)
from floor_localizer.core.constellation.search_state import Search, is_accepted, judge

# Tolerance of a coordinate in standard deviations: wide enough to keep nine of ten true constellations.
_KEY_GATE = 2.3
# A base is too short to look up when its tolerance would be wider than this: nearly every key would be
# within.
_WIDEST_TOLERANCE = 0.08
_ORDERS = np.array(list(itertools.permutations(range(OTHERS))))


@njit(cache=True)
def search_constellations(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search, most_cells: int
) -> bool:
    """Look up the view's constellations until a pose is accepted or the budget is spent."""
    lens = np.empty(MOST_IN_LENS, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    seeds = np.empty(2 + OTHERS, dtype=np.int64)
    bases, lengths, crowds = _list_bases(view, index.reach * (1.0 + view.scale_tolerance))
    for b in np.argsort(crowds):
        first, second = bases[b]
        longest = lengths[b] + 2.0 * view.sigma
        inside = dots_in_lens(view.points, first, second, view.nearest[first], longest, lens)
        found = groups_of_four(view.points, lens[:inside], longest, groups)
        for g in range(found):
            seeds[0], seeds[1], seeds[2:] = first, second, groups[g]
            if _look_up(grid, index, view, search, lengths[b], seeds):
                return True
            if search.counts[0] >= most_cells:
                return False
    return False


@njit(cache=True)
def _list_bases(
    view: ViewDots, longest: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """List the bases of a view up to a length that have dots enough for a constellation.

    Returns:
        their ends, shape (p, 2), their lengths [m], shape (p,), and the number of dots in their lenses, shape
        (p,), less a fraction that puts the longer before the shorter.
    """
    n, m = view.nearest.shape
    shortest = key_tolerance(view.sigma, _WIDEST_TOLERANCE)
    bases = np.empty((n * m, 2), dtype=np.int64)
    lengths = np.empty(n * m)
    crowds = np.empty(n * m)
    lens = np.empty(MOST_IN_LENS, dtype=np.int64)
    count = 0
    for first in range(n):
        for second in view.nearest[first]:
            length = distance(view.points, first, second)
            if length > longest:
                break
            if first > second or length < shortest:
                continue
            inside = dots_in_lens(
                view.points, first, second, view.nearest[first], length + 2.0 * view.sigma, lens
            )
            if inside < OTHERS:
                continue
            bases[count, 0], bases[count, 1] = first, second
            lengths[count] = length
            crowds[count] = inside - length / longest
            count += 1
    return bases[:count], lengths[:count], crowds[:count]


@njit(cache=True)
def key_tolerance(sigma: float, length: float) -> float:
    """Return how far a coordinate of a key may be off for dots of standard deviation ``sigma`` [m] on a base
    [m].

    The dot's own noise and that of the base's ends add up to 1.25 sigma on average. Tolerance and length may
    change places: the result for a given tolerance is the length that has it.
    """
    return _KEY_GATE * 1.25 * sigma / length


@njit(cache=True)
def _look_up(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: Search,
    length: float,
    seeds: NDArray[np.int64],
) -> bool:
    """Look up one constellation, with either end first and in every order that noise allows.

    It is looked up to the end even when a pose is accepted, so that a place that looks the same is found too.
    """
    xy = np.empty((OTHERS, 2))
    base_coordinates(view.points, seeds[0], seeds[1], seeds[2:], xy)
    tolerance = key_tolerance(view.sigma, length)
    tie = 1.4 * tolerance
    beyond = imbalance(xy)
    turned = seeds.copy()
    for side in range(2):
        if side == 1:
            turn_around(xy)
            beyond = -beyond
            turned[0], turned[1] = seeds[1], seeds[0]
        if beyond > tolerance:
            continue
        for order in _ORDERS:
            if _is_order(xy, order, tie):
                _probe(grid, index, view, search, turned, xy, order, tolerance)
    return is_accepted(search, search.best)


@njit(cache=True)
def _is_order(xy: NDArray[np.float64], order: NDArray[np.int64], tie: float) -> bool:
    """Tell whether the dots may be in this order of x, if two that are nearer than ``tie`` can be either way
    round.
    """
    for k in range(OTHERS):
        for m in range(k):
            if xy[order[m], 0] > xy[order[k], 0] + tie:
                return False
    return True


@njit(cache=True)
def _probe(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: Search,
    seeds: NDArray[np.int64],
    xy: NDArray[np.float64],
    order: NDArray[np.int64],
    tolerance: float,
) -> None:
    """Try the indexed constellations whose eight coordinates are within the tolerance."""
    lower, first_cell = _limits(xy, order, -tolerance)
    upper, last_cell = _limits(xy, order, tolerance)
    cells = first_cell.copy()
    while True:
        bucket = bucket_of_cells(cells, index.bits)
        search.counts[0] += 1
        for entry in range(index.starts[bucket], index.starts[bucket + 1]):
            if is_within(index.codes[entry], lower, upper):
                search.counts[1] += 1
                good, a, b = grow(grid, view, seeds, index.bases[entry, 0], index.bases[entry, 1])
                if good:
                    judge(grid, view, search, a, b)
        k = 0
        while k < LANES and cells[k] == last_cell[k]:
            cells[k] = first_cell[k]
            k += 1
        if k == LANES:
            return
        cells[k] += 1


@njit(cache=True)
def _limits(
    xy: NDArray[np.float64], order: NDArray[np.int64], shift: float
) -> tuple[np.uint64, NDArray[np.int64]]:
    """Return the packed steps and hash cells, shape (8,), of coordinates shifted by a tolerance."""
    steps = np.empty(LANES, dtype=np.int64)
    cells = np.empty(LANES, dtype=np.int64)
    for k in range(OTHERS):
        x = to_steps(xy[order[k], 0] + shift, X_LOWER, X_STEPS)
        y = to_steps(xy[order[k], 1] + shift, Y_LOWER, Y_STEPS)
        steps[2 * k], steps[2 * k + 1] = x, y
        cells[2 * k], cells[2 * k + 1] = x // X_CELL, y // Y_CELL
    return pack(steps), cells
