"""Look the constellations of a view up in the index until one grows to a pose that cannot be chance."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import grow
from floor_localizer.core.constellation.constellation_bases import ViewBases, list_bases
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.constellation_key import (
    OTHERS,
    base_coordinates,
)
from floor_localizer.core.constellation.constellation_lookups import (
    Lookups,
    Wanted,
    add_constellation,
    fits,
    is_full,
    key_coordinates,
    no_lookups,
)
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.index_entry import (
    LENGTH_ROUNDING,
    first_of_entry,
    length_of_entry,
    parts_of_entry,
    second_of_entry,
)
from floor_localizer.core.constellation.lens import MOST_GROUPS, distance, dots_in_lens, groups_of_four
from floor_localizer.core.constellation.search_state import Search, judge
from floor_localizer.core.constellation.view_dots import ViewDots

# A base is too short to look up when the noise is more than this share of it: nearly every key would fit.
_NOISIEST = 0.028
# Six dots fit when the sum of their squared residuals over the noise's is below: 97.5 % of chi square of 8 degrees.
_MISFIT_MAX = 17.5
# 80 % of the right keys fit as closely as this, and of the wrong ones that fit, (11 / 17.5)**4, a seventh.
_CLOSE = 11.0
# In an index of more keys wrong ones that fit cost more than all else: the close ones are tried first.
_MANY_KEYS = 30_000_000
# The base of a key may be longer or shorter by so many standard deviations of a dot's place.
_LENGTH_GATE = 3.7
# Cells are opened in rounds, the likely ones first: their probability, from and below, and the misfit, from and below.
_ROUNDS = np.array(
    [
        (0.1, math.inf, 0.0, _MISFIT_MAX),
        (0.02, 0.1, 0.0, _MISFIT_MAX),
        (0.004, 0.02, 0.0, _MISFIT_MAX),
        (0.0008, 0.004, 0.0, _MISFIT_MAX),
    ]
)
_ROUNDS_OF_MANY = np.array(
    [
        (0.1, math.inf, 0.0, _CLOSE),
        (0.02, 0.1, 0.0, _CLOSE),
        (0.02, math.inf, _CLOSE, _MISFIT_MAX),
        (0.004, 0.02, 0.0, _MISFIT_MAX),
        (0.0008, 0.004, 0.0, _MISFIT_MAX),
    ]
)
# A constellation with one more dot in its lens is so much less likely to be whole.
_FADING = 0.8
# Places that look the same are looked for in cells as unlikely as this.
_LEAST_ALIKE = 0.003
# Of no entry; typed, because numba compiles a function once more for a bare number.
_UNKNOWN = np.int64(-1)


class Round(NamedTuple):
    """What is tried together.

    Attributes:
        cells: which cells are opened.
        misfit_from: keys that fit more closely were tried before.
        misfit_below: keys that fit less closely are not tried.
    """

    cells: Wanted
    misfit_from: float
    misfit_below: float


@njit(cache=True)
def search_constellations(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search, most_cells: int
) -> bool:
    """Look up the view's constellations until a pose is accepted or ``most_cells`` cells are opened."""
    return search_in_rounds(grid, index, view, search, rounds_for(len(index.entries)), most_cells)


@njit(cache=True)
def rounds_for(keys: int) -> NDArray[np.float64]:
    """Return the rounds for an index of so many keys, shape (r, 4), as they stand at the top of this file."""
    return _ROUNDS_OF_MANY if keys > _MANY_KEYS else _ROUNDS


@njit(cache=True)
def search_in_rounds(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: Search,
    rounds: NDArray[np.float64],
    most_cells: int,
) -> bool:
    """Look up the view's constellations, rounds as `rounds_for` gives; otherwise as `search_constellations`."""
    bases = list_bases(view, view.sigma / _NOISIEST, index.longest * (1.0 + view.scale_tolerance))
    lookups = no_lookups()
    for least, below, misfit_from, misfit_below in rounds:
        one = Round(Wanted(least, below), misfit_from, misfit_below)
        if _search_round(grid, index, view, search, bases, lookups, one, most_cells):
            return True
        if search.counts[0] >= most_cells:
            return False
    return False


@njit(cache=True)
def _search_round(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: Search,
    bases: ViewBases,
    lookups: Lookups,
    one: Round,
    most_cells: int,
) -> bool:
    """Open the wanted cells of all constellations."""
    wanted = one.cells
    lens = np.empty(int(np.max(bases.crowds)) if len(bases.crowds) > 0 else 1, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    seeds = np.empty(2 + OTHERS, dtype=np.int64)
    xy = np.empty((OTHERS, 2))
    for b in range(len(bases.lengths)):
        # Less likely to be whole: only its likelier cells are worth as much as others' cells.
        faded = _FADING ** (bases.crowds[b] - OTHERS)
        if wanted.least > faded:
            break
        first, second = bases.ends[b]
        longest = bases.lengths[b] + 2.0 * view.sigma
        inside = dots_in_lens(view.points, first, second, view.nearest[first], longest, lens)
        found = groups_of_four(view.points, lens[:inside], longest, groups)
        for g in range(found):
            seeds[0], seeds[1] = first, second
            for k in range(OTHERS):
                seeds[2 + k] = groups[g, k]
            base_coordinates(view.points, first, second, seeds[2:], xy)
            noise = view.sigma / bases.lengths[b]
            add_constellation(
                index, lookups, seeds, xy, noise, Wanted(wanted.least / faded, wanted.below / faded)
            )
            if is_full(lookups):
                if _look_up(grid, index, view, search, lookups, one):
                    return True
                if search.counts[0] >= most_cells:
                    return False
    return _look_up(grid, index, view, search, lookups, one)


@njit(cache=True)
def _look_up(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: Search, lookups: Lookups, one: Round
) -> bool:
    """Try all keys that fit until a pose is accepted; then those of the same key, for places that look the same."""
    lookup, entry = _try_entries(grid, index, view, search, lookups, one, _UNKNOWN)
    if lookup < 0:
        return False
    owner = lookups.owners[lookup]
    seeds, noise = lookups.seeds[owner].copy(), lookups.noise[owner]
    xy = np.empty((OTHERS, 2))
    key_coordinates(lookups, lookup, parts_of_entry(index.entries[entry]), index.step, xy)
    lookups.counts[:] = 0
    alike = Round(Wanted(_LEAST_ALIKE, math.inf), 0.0, _MISFIT_MAX)
    add_constellation(index, lookups, seeds, xy, noise, alike.cells)
    _try_entries(grid, index, view, search, lookups, alike, entry)
    return True


@njit(cache=True)
def _try_entries(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: Search,
    lookups: Lookups,
    one: Round,
    known: int,
) -> tuple[int, int]:
    """Open all cells and return the cell and the entry of the index that an accepted pose comes from, or -1 twice.

    With the ``known`` entry that it came from, not -1, the others are tried to the end.
    All beginnings, then all first keys are read before any is used: they are far apart in memory, and so the processor
    waits for them together.
    """
    count = lookups.counts[1]
    begins, ends = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    heads = np.zeros(count, dtype=np.uint64)
    for c in range(count):
        begins[c] = index.starts[lookups.buckets[c]]
        ends[c] = index.starts[lookups.buckets[c] + 1]
    for c in range(count):
        if begins[c] < ends[c]:
            heads[c] = index.entries[begins[c]]
    search.counts[0] += count
    lookups.counts[:] = 0
    key = np.empty((OTHERS, 2))
    for c in range(count):
        for place in range(begins[c], ends[c]):
            entry = heads[c] if place == begins[c] else index.entries[place]
            if place == known or not fits(lookups, c, parts_of_entry(entry)):
                continue
            key_coordinates(lookups, c, parts_of_entry(entry), index.step, key)
            if not _is_alike(view, lookups, lookups.owners[c], key, index, entry, one):
                continue
            search.counts[1] += 1
            first = first_of_entry(entry)
            second = second_of_entry(grid, entry, first, index.longest)
            if second < 0:
                continue
            good, a, b = grow(grid, view, lookups.seeds[lookups.owners[c]], first, second)
            if good and judge(grid, view, search, a, b) and known < 0:
                return c, place
    return -1, -1


@njit(cache=True)
def _is_alike(
    view: ViewDots,
    lookups: Lookups,
    owner: int,
    key: NDArray[np.float64],
    index: ConstellationIndex,
    entry: np.uint64,
    one: Round,
) -> bool:
    """Tell whether a key, shape (4, 2), fits a constellation of the view, and the length of its base as well."""
    noise, rounding = lookups.noise[owner], index.step / math.sqrt(12.0)
    misfit = _misfit(key, lookups.xy[owner]) / (noise * noise + rounding * rounding)
    if misfit >= one.misfit_below or misfit < one.misfit_from:
        return False
    length = distance(view.points, lookups.seeds[owner, 0], lookups.seeds[owner, 1])
    room = view.scale_tolerance + LENGTH_ROUNDING + _LENGTH_GATE * noise
    return abs(length / length_of_entry(entry, index.longest) - 1.0) <= room


@njit(cache=True)
def _misfit(key: NDArray[np.float64], xy: NDArray[np.float64]) -> float:
    """Return the sum of squared residuals of the best similarity from six dots to those of a key.

    Args:
        key: shape (4, 2), coordinates of the others of the key; the base's ends are (0, 0) and (1, 0) on either side.
        xy: shape (4, 2), those of the view.
    """
    z, t = complex(1.0, 0.0), complex(1.0, 0.0)
    zz, tt, zt = 1.0, 1.0, complex(1.0, 0.0)
    for k in range(OTHERS):
        dot, place = complex(xy[k, 0], xy[k, 1]), complex(key[k, 0], key[k, 1])
        z, t, zt = z + dot, t + place, zt + dot.conjugate() * place
        zz += dot.real * dot.real + dot.imag * dot.imag
        tt += place.real * place.real + place.imag * place.imag
    n = 2.0 + OTHERS
    zz -= (z.real * z.real + z.imag * z.imag) / n
    tt -= (t.real * t.real + t.imag * t.imag) / n
    zt -= z.conjugate() * t / n
    return tt - (zt.real * zt.real + zt.imag * zt.imag) / zz
