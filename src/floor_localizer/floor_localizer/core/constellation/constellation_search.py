"""Look the constellations of a view up in the index until one grows to a pose that cannot be chance."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.acceptance import expected_chance_alignments
from floor_localizer.core.constellation.alignment import ViewDots, _contains, grow, match_view
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
from floor_localizer.core.constellation.lens import MOST_GROUPS, distance, groups_on_base

# Tolerance of a coordinate in standard deviations: wide enough to keep nine of ten true constellations.
_KEY_GATE = 2.3
_ORDERS = np.array(list(itertools.permutations(range(OTHERS))))


class Search(NamedTuple):
    """State of a search, shared by its steps.

    Attributes:
        best: shape (6,): expected chance alignments, a.real, a.imag, b.real, b.imag, number of matches.
        counts: shape (3,): constellations looked up, guesses tried, guesses matched over the whole view.
        matches: shape (n,), room for the matches of a guess.
        residuals: shape (n,), room for their residuals.
        accept_below: a pose is taken when fewer chance alignments are expected.
        match_rate_min: and at least this share of the view's dots is matched.
    """

    best: NDArray[np.float64]
    counts: NDArray[np.int64]
    matches: NDArray[np.int64]
    residuals: NDArray[np.float64]
    accept_below: float
    match_rate_min: float


@njit(cache=True)
def judge(
    grid: DotGrid, view: ViewDots, search: Search, a: complex, b: complex
) -> bool:
    """Match the whole view under a guess, keep it if it is the best so far, and tell whether it is accepted."""
    search.counts[2] += 1
    matched, a, b = match_view(grid, view, a, b, search.matches, search.residuals)
    if matched < 3 or abs(abs(a) - 1.0) > 1.3 * view.scale_tolerance + 0.01:
        return False
    expected = expected_chance_alignments(
        search.residuals, 0.5 * view.sigma, _widest(view, search.matches), float(len(grid.points)),
        view.density, view.scale_tolerance,
    )
    if expected < search.best[0]:
        search.best[0] = expected
        search.best[1], search.best[2] = a.real, a.imag
        search.best[3], search.best[4] = b.real, b.imag
        search.best[5] = matched
    return (
        expected < search.accept_below and matched >= search.match_rate_min * len(view.z)
    )


@njit(cache=True)
def _widest(view: ViewDots, matches: NDArray[np.int64]) -> float:
    """Return the distance of the two farthest matched dots [m], by the diagonal of their bounding box."""
    x0 = y0 = math.inf
    x1 = y1 = -math.inf
    for k in range(len(matches)):
        if matches[k] >= 0:
            x0, x1 = min(x0, view.points[k, 0]), max(x1, view.points[k, 0])
            y0, y1 = min(y0, view.points[k, 1]), max(y1, view.points[k, 1])
    return math.hypot(x1 - x0, y1 - y0)


@njit(cache=True)
def search_constellations(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search, most_lookups: int
) -> bool:
    """Look up the view's constellations until a pose is accepted or the budget is spent."""
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    seeds = np.empty(2 + OTHERS, dtype=np.int64)
    bases, lengths = _list_bases(view, index.reach * (1.0 + view.scale_tolerance))
    # Long bases tell most, but those near the index's reach may be just beyond it for a camera that hangs low.
    safe = index.reach * (1.0 - view.scale_tolerance)
    for b in np.argsort(np.abs(lengths - safe)):
        first, second = bases[b]
        longest = lengths[b] + 2.0 * view.sigma
        found = groups_on_base(view.points, first, second, view.nearest[first], longest, groups)
        for g in range(found):
            seeds[0], seeds[1], seeds[2:] = first, second, groups[g]
            search.counts[0] += 1
            if _look_up(grid, index, view, search, lengths[b], seeds):
                return True
        if search.counts[0] >= most_lookups:
            return False
    return False


@njit(cache=True)
def _list_bases(view: ViewDots, longest: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return all pairs of neighbours up to a length, shape (p, 2), and their lengths [m], shape (p,)."""
    n, m = view.nearest.shape
    bases = np.empty((n * m, 2), dtype=np.int64)
    lengths = np.empty(n * m)
    count = 0
    for first in range(n):
        for k in range(m):
            second = view.nearest[first, k]
            length = distance(view.points, first, second)
            if length > longest:
                break
            if first < second or not _contains(view.nearest[second], first):
                bases[count, 0], bases[count, 1] = first, second
                lengths[count] = length
                count += 1
    return bases[:count], lengths[:count]


@njit(cache=True)
def _look_up(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search, length: float, seeds: NDArray[np.int64]
) -> bool:
    """Look up one constellation, with either end first and in every order that noise allows."""
    xy = np.empty((OTHERS, 2))
    base_coordinates(view.points, seeds[0], seeds[1], seeds[2:], xy)
    tolerance = _KEY_GATE * view.sigma / length * 1.25
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
            if _is_order(xy, order, tie) and _probe(grid, index, view, search, turned, xy, order, tolerance):
                return True
    return False


@njit(cache=True)
def _is_order(xy: NDArray[np.float64], order: NDArray[np.int64], tie: float) -> bool:
    """Tell whether the dots may be in this order of x, if two that are nearer than ``tie`` can be either way round."""
    for k in range(OTHERS):
        for m in range(k):
            if xy[order[m], 0] > xy[order[k], 0] + tie:
                return False
    return True


@njit(cache=True)
def _probe(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search,
    seeds: NDArray[np.int64], xy: NDArray[np.float64], order: NDArray[np.int64], tolerance: float,
) -> bool:
    """Try the indexed constellations whose eight coordinates are within the tolerance."""
    lower, first_cell = _limits(xy, order, -tolerance)
    upper, last_cell = _limits(xy, order, tolerance)
    cells = first_cell.copy()
    while True:
        bucket = bucket_of_cells(cells, index.bits)
        for entry in range(index.starts[bucket], index.starts[bucket + 1]):
            if is_within(index.codes[entry], lower, upper):
                search.counts[1] += 1
                good, a, b = grow(grid, view, seeds, index.bases[entry, 0], index.bases[entry, 1])
                if good and judge(grid, view, search, a, b):
                    return True
        k = 0
        while k < LANES and cells[k] == last_cell[k]:
            cells[k] = first_cell[k]
            k += 1
        if k == LANES:
            return False
        cells[k] += 1


@njit(cache=True)
def _limits(
    xy: NDArray[np.float64], order: NDArray[np.int64], shift: float
) -> tuple[np.uint64, NDArray[np.int64]]:
    """Return the packed steps and the hash cells, shape (8,), of coordinates that are shifted by a tolerance."""
    steps = np.empty(LANES, dtype=np.int64)
    cells = np.empty(LANES, dtype=np.int64)
    for k in range(OTHERS):
        x = to_steps(xy[order[k], 0] + shift, X_LOWER, X_STEPS)
        y = to_steps(xy[order[k], 1] + shift, Y_LOWER, Y_STEPS)
        steps[2 * k], steps[2 * k + 1] = x, y
        cells[2 * k], cells[2 * k + 1] = x // X_CELL, y // Y_CELL
    return pack(steps), cells
