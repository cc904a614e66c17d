"""Look up the constellations of a view in the index until one yields a pose that is significant."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.acceptance import SearchState, score_hypothesis
from floor_localizer.core.constellation.alignment import verify_hypothesis
from floor_localizer.core.constellation.baselines import (
    MAX_QUADRUPLES,
    ViewBaselines,
    distance,
    dots_in_lune,
    list_baselines,
    list_quadruples,
)
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.constellation_key import INNER_DOTS, baseline_coordinates
from floor_localizer.core.constellation.constellation_lookups import (
    Lookups,
    ProbabilityRange,
    add_constellation,
    allocate_lookups,
    is_compatible,
    is_full,
    key_coordinates,
)
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.index_format import (
    LENGTH_ROUNDING,
    first_dot_of_entry,
    length_of_entry,
    second_dot_of_entry,
    subcell_of_entry,
)
from floor_localizer.core.dots import ViewDots

# Maximum noise of a baseline as a fraction of its length; with more noise nearly every key would match.
_RELATIVE_NOISE_MAX = 0.028
# Gate on the normalized squared residuals of six dots: 97.5 % quantile of chi-square with 8 degrees of freedom.
_MISFIT_MAX = 17.5
# Below this misfit are 80 % of the right keys but only a seventh, (11 / 17.5)**4, of the wrong ones inside the gate.
_CLOSE_MISFIT = 11.0
# In an index of more keys, wrong keys inside the gate dominate the cost: keys with a small misfit are tested first.
_LARGE_INDEX_KEYS = 30_000_000
# Gate on the length of a key's baseline [standard deviations of a dot's position].
_LENGTH_GATE = 3.7
# Cells are opened in rounds, the likely ones first: ranges of probability [min, max) and misfit [min, max).
_ROUNDS = np.array(
    [
        (0.1, math.inf, 0.0, _MISFIT_MAX),
        (0.02, 0.1, 0.0, _MISFIT_MAX),
        (0.004, 0.02, 0.0, _MISFIT_MAX),
        (0.0008, 0.004, 0.0, _MISFIT_MAX),
    ]
)
_LARGE_INDEX_ROUNDS = np.array(
    [
        (0.1, math.inf, 0.0, _CLOSE_MISFIT),
        (0.02, 0.1, 0.0, _CLOSE_MISFIT),
        (0.02, math.inf, _CLOSE_MISFIT, _MISFIT_MAX),
        (0.004, 0.02, 0.0, _MISFIT_MAX),
        (0.0008, 0.004, 0.0, _MISFIT_MAX),
    ]
)
# Factor on the probability that a constellation is complete, for each further dot in its lune.
_EXTRA_DOT_FACTOR = 0.8
# Minimum probability of the cells in which repetitions of the accepted place are searched.
_REPEAT_PROBABILITY_MIN = 0.003
# Index of no entry; typed, because numba would compile a second version for a plain int.
_NO_ENTRY = np.int64(-1)


class SearchRound(NamedTuple):
    """Cells (range of probability) and keys (misfit from, to below) that are tested in one round."""

    cells: ProbabilityRange
    misfit_from: float
    misfit_below: float


@njit(cache=True)
def search_constellations(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: SearchState, max_cells: int
) -> bool:
    """Look up the view's constellations until a pose is accepted or ``max_cells`` cells are opened."""
    return run_search_rounds(grid, index, view, search, rounds_for_index(len(index.entries)), max_cells)


@njit(cache=True)
def rounds_for_index(keys: int) -> Floats:
    """Return the rounds for an index with a number of keys, shape (r, 4): probability and misfit ranges."""
    return _LARGE_INDEX_ROUNDS if keys > _LARGE_INDEX_KEYS else _ROUNDS


@njit(cache=True)
def run_search_rounds(
    grid: DotGrid, index: ConstellationIndex, view: ViewDots, search: SearchState, rounds: Floats, max_cells: int
) -> bool:
    """Look up the view's constellations in the rounds of `rounds_for_index`; else as `search_constellations`."""
    baselines = list_baselines(view, view.sigma / _RELATIVE_NOISE_MAX, index.longest * (1.0 + view.scale_tolerance))
    lookups = allocate_lookups()
    for minimum, maximum, misfit_from, misfit_below in rounds:
        current_round = SearchRound(ProbabilityRange(minimum, maximum), misfit_from, misfit_below)
        if _search_round(grid, index, view, search, baselines, lookups, current_round, max_cells):
            return True
        if search.counts[0] >= max_cells:
            return False
    return False


@njit(cache=True)
def _search_round(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: SearchState,
    baselines: ViewBaselines,
    lookups: Lookups,
    current_round: SearchRound,
    max_cells: int,
) -> bool:
    """Open the cells of one round for all constellations."""
    probability_range = current_round.cells
    lune = np.empty(int(np.max(baselines.lune_counts)) if len(baselines.lune_counts) > 0 else 1, dtype=np.int64)
    quadruples = np.empty((MAX_QUADRUPLES, INNER_DOTS), dtype=np.int64)
    seeds = np.empty(2 + INNER_DOTS, dtype=np.int64)
    xy = np.empty((INNER_DOTS, 2))
    for b in range(len(baselines.lengths)):
        # Less likely to be complete: its cells must be more likely to be worth as much as other constellations' cells.
        completeness = _EXTRA_DOT_FACTOR ** (baselines.lune_counts[b] - INNER_DOTS)
        if probability_range.minimum > completeness:
            break
        first, second = baselines.ends[b]
        longest = baselines.lengths[b] + 2.0 * view.sigma
        inside = dots_in_lune(view.points, first, second, view.neighbours[first], longest, lune)
        found = list_quadruples(view.points, lune[:inside], longest, quadruples)
        for g in range(found):
            seeds[0], seeds[1] = first, second
            for k in range(INNER_DOTS):
                seeds[2 + k] = quadruples[g, k]
            baseline_coordinates(view.points, first, second, seeds[2:], xy)
            noise = view.sigma / baselines.lengths[b]
            add_constellation(
                index,
                lookups,
                seeds,
                xy,
                noise,
                ProbabilityRange(probability_range.minimum / completeness, probability_range.maximum / completeness),
            )
            if is_full(lookups):
                if _look_up(grid, index, view, search, lookups, current_round):
                    return True
                if search.counts[0] >= max_cells:
                    return False
    return _look_up(grid, index, view, search, lookups, current_round)


@njit(cache=True)
def _look_up(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: SearchState,
    lookups: Lookups,
    current_round: SearchRound,
) -> bool:
    """Test all compatible keys until a pose is accepted; then its key's other entries, to find repeated places."""
    lookup, entry = _try_entries(grid, index, view, search, lookups, current_round, _NO_ENTRY)
    if lookup < 0:
        return False
    owner = lookups.owners[lookup]
    seeds, noise = lookups.seeds[owner].copy(), lookups.noise[owner]
    xy = np.empty((INNER_DOTS, 2))
    key_coordinates(lookups, lookup, subcell_of_entry(index.entries[entry]), index.step, xy)
    lookups.counts[:] = 0
    repeat_round = SearchRound(ProbabilityRange(_REPEAT_PROBABILITY_MIN, math.inf), 0.0, _MISFIT_MAX)
    add_constellation(index, lookups, seeds, xy, noise, repeat_round.cells)
    _try_entries(grid, index, view, search, lookups, repeat_round, entry)
    return True


@njit(cache=True)
def _try_entries(
    grid: DotGrid,
    index: ConstellationIndex,
    view: ViewDots,
    search: SearchState,
    lookups: Lookups,
    current_round: SearchRound,
    known_entry: int,
) -> tuple[int, int]:
    """Open all cells and return the cell and the index entry of the accepted pose, or -1 twice.

    With ``known_entry``, the entry of an already accepted pose, all other entries are tested.
    All bucket begins, then all first entries are read before any is used: they are scattered in memory, and the cache
    misses overlap this way.
    """
    count = lookups.counts[1]
    begins, ends = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    first_entries = np.zeros(count, dtype=np.uint64)
    for c in range(count):
        begins[c] = index.starts[lookups.buckets[c]]
        ends[c] = index.starts[lookups.buckets[c] + 1]
    for c in range(count):
        if begins[c] < ends[c]:
            first_entries[c] = index.entries[begins[c]]
    search.counts[0] += count
    lookups.counts[:] = 0
    key = np.empty((INNER_DOTS, 2))
    for c in range(count):
        for place in range(begins[c], ends[c]):
            entry = first_entries[c] if place == begins[c] else index.entries[place]
            if place == known_entry or not is_compatible(lookups, c, subcell_of_entry(entry)):
                continue
            key_coordinates(lookups, c, subcell_of_entry(entry), index.step, key)
            if not _is_key_match(view, lookups, lookups.owners[c], key, index, entry, current_round):
                continue
            search.counts[1] += 1
            first = first_dot_of_entry(entry)
            second = second_dot_of_entry(grid, entry, first, index.longest)
            if second < 0:
                continue
            is_supported, a, b = verify_hypothesis(grid, view, lookups.seeds[lookups.owners[c]], first, second)
            if is_supported and score_hypothesis(grid, view, search, a, b) and known_entry < 0:
                return c, place
    return -1, -1


@njit(cache=True)
def _is_key_match(
    view: ViewDots,
    lookups: Lookups,
    owner: int,
    key: Floats,
    index: ConstellationIndex,
    entry: np.uint64,
    current_round: SearchRound,
) -> bool:
    """Return whether a key, shape (4, 2), and the length of its baseline match a constellation of the view."""
    noise, rounding = lookups.noise[owner], index.step / math.sqrt(12.0)
    misfit = _misfit(key, lookups.xy[owner]) / (noise * noise + rounding * rounding)
    if misfit >= current_round.misfit_below or misfit < current_round.misfit_from:
        return False
    length = distance(view.points, lookups.seeds[owner, 0], lookups.seeds[owner, 1])
    tolerance = view.scale_tolerance + LENGTH_ROUNDING + _LENGTH_GATE * noise
    return abs(length / length_of_entry(entry, index.longest) - 1.0) <= tolerance


@njit(cache=True)
def _misfit(key: Floats, xy: Floats) -> float:
    """Return the sum of squared residuals of the least-squares similarity from a view's six dots to a key's.

    ``key`` and ``xy`` are the inner dots, shape (4, 2); the baseline's ends are (0, 0) and (1, 0) in both.
    """
    z, t = complex(1.0, 0.0), complex(1.0, 0.0)
    zz, tt, zt = 1.0, 1.0, complex(1.0, 0.0)
    for k in range(INNER_DOTS):
        dot, place = complex(xy[k, 0], xy[k, 1]), complex(key[k, 0], key[k, 1])
        z, t, zt = z + dot, t + place, zt + dot.conjugate() * place
        zz += dot.real * dot.real + dot.imag * dot.imag
        tt += place.real * place.real + place.imag * place.imag
    n = 2.0 + INNER_DOTS
    zz -= (z.real * z.real + z.imag * z.imag) / n
    tt -= (t.real * t.real + t.imag * t.imag) / n
    zt -= z.conjugate() * t / n
    return tt - (zt.real * zt.real + zt.imag * zt.imag) / zz
