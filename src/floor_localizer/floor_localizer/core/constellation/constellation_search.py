"""Look the constellations of a view up in the index until one grows to a pose that cannot be chance."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.acceptance import log_chance_alignments
from floor_localizer.core.constellation.alignment import ViewDots, grow, match_view
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

# Tolerance of a coordinate in standard deviations: wide enough to keep nine of ten true constellations.
_KEY_GATE = 2.3
# A base is too short to look up when its tolerance would be wider than this: nearly every key would be
# within.
_WIDEST_TOLERANCE = 0.08
# The fitted scale may be off by this much more than the camera's height, for its own error.
_SCALE_MARGIN = 1.3
_ORDERS = np.array(list(itertools.permutations(range(OTHERS))))


class Search(NamedTuple):
    """State of a search, shared by its steps.

    Attributes:
        best: shape (6,): logarithm of the expected chance alignments, a.real, a.imag, b.real, b.imag, matched
            dots.
        rival: shape (6,), the same of the best pose elsewhere.
        counts: shape (3,): cells of the index opened, guesses tried, guesses matched over the whole view.
        matches: shape (n,), room for the matches of a guess.
        residuals: shape (n,), room for their residuals.
        dots_in_scope: number of map dots where the pose may be.
        log_accept: a pose is taken when the logarithm of the expected chance alignments is below this.
        least_matches: and at least so many dots are matched.
    """

    best: NDArray[np.float64]
    rival: NDArray[np.float64]
    counts: NDArray[np.int64]
    matches: NDArray[np.int64]
    residuals: NDArray[np.float64]
    dots_in_scope: float
    log_accept: float
    least_matches: float


def new_search(dots: int, dots_in_scope: float, accept_below: float, match_rate_min: float) -> Search:
    """Return the state of a search that has not begun.

    Args:
        dots: number of dots in view.
        dots_in_scope: number of map dots where the pose may be.
        accept_below: a pose is taken when fewer chance alignments are expected.
        match_rate_min: and at least this share of the dots in view is matched.
    """
    nothing = np.array([math.inf, 1.0, 0.0, 0.0, 0.0, 0.0])
    return Search(
        nothing,
        nothing.copy(),
        np.zeros(3, dtype=np.int64),
        np.empty(dots, dtype=np.int64),
        np.empty(dots),
        dots_in_scope,
        math.log(accept_below),
        match_rate_min * dots,
    )


@njit(cache=True)
def is_accepted(search: Search, pose: NDArray[np.float64]) -> bool:
    """Tell whether ``search.best`` or ``search.rival`` is no chance."""
    return pose[0] < search.log_accept and pose[5] >= search.least_matches


@njit(cache=True)
def judge(grid: DotGrid, view: ViewDots, search: Search, a: complex, b: complex) -> bool:
    """Match the whole view under a guess, keep the best pose and its rival, and tell whether the best is
    accepted.
    """
    search.counts[2] += 1
    matched, a, b = match_view(grid, view, a, b, search.matches, search.residuals)
    if matched < 3 or abs(abs(a) - 1.0) > _SCALE_MARGIN * view.scale_tolerance:
        return False
    chance = log_chance_alignments(
        search.residuals,
        0.5 * view.sigma,
        _widest(view, search.matches),
        search.dots_in_scope,
        view.density,
        view.scale_tolerance,
    )
    pose = np.array([chance, a.real, a.imag, b.real, b.imag, float(matched)])
    if chance < search.best[0]:
        if not _same_place(grid, view, pose, search.best):
            search.rival[:] = search.best
        search.best[:] = pose
    elif chance < search.rival[0] and not _same_place(grid, view, pose, search.best):
        search.rival[:] = pose
    return is_accepted(search, search.best)


@njit(cache=True)
def _same_place(grid: DotGrid, view: ViewDots, pose: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Tell whether two poses put the view at the same place with the same heading."""
    turn = complex(pose[1] - other[1], pose[2] - other[2])
    shift = turn * view.z[0] + complex(pose[3] - other[3], pose[4] - other[4])
    return abs(shift) < 0.5 * grid.cell and abs(turn) < 0.2


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
