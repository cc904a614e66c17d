"""The index: a geometric hash table of all small constellations of six map dots."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.baselines import MAX_QUADRUPLES, list_quadruples
from floor_localizer.core.constellation.constellation_key import (
    INNER_DOTS,
    KEY_SIZE,
    baseline_coordinates,
    bucket_of_hash,
    hash_cell,
    mean_x_offset,
    pack_subcell,
    quantize_coordinates,
    sort_by_x,
    swap_ends,
)
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.index_format import (
    IndexRules,
    index_rules,
    pack_baseline,
    pack_entry,
    second_dot_of_entry,
)

# Maximum number of dots in the lune of an indexed baseline.
INDEX_LUNE_DOTS_MAX = 6
_NEIGHBOURS = 64
_UNCHECKED, _RECOVERABLE, _UNRECOVERABLE = 0, 1, 2
# Constellations per dot for which memory is allocated initially.
_INITIAL_CAPACITY = 18


class ConstellationIndex(NamedTuple):
    """Constellations of six dots, hashed by their key; the arrays may be memory-mapped.

    Attributes:
        entries: shape (M,) uint64, packed constellations, bucket by bucket.
        starts: shape (buckets + 1,) uint32, first entry of each bucket.
        step: quantization step, an eighth of a cell's side [baseline lengths].
        longest: maximum length of a baseline [m].
    """

    entries: NDArray[np.uint64]
    starts: NDArray[np.uint32]
    step: float
    longest: float


class Neighbourhood(NamedTuple):
    """A dot and its neighbours.

    Attributes:
        dots: shape (64,), indices in the grid.
        points: shape (64, 2), offsets from the first dot [m].
        x: shape (64,), offsets along x [m].
        y: shape (64,), offsets along y [m].
        squared: shape (64,), squared distances from the first dot [m^2].
        candidates: shape (64,), buffer for the unsorted neighbours.
    """

    dots: Ints
    points: Floats
    x: Floats
    y: Floats
    squared: Floats
    candidates: Ints


class _KeyBuffers(NamedTuple):
    """Buffers for the keys of one baseline.

    Attributes:
        xy: shape (4, 2), coordinates of the inner dots.
        steps: shape (8,), quantized coordinates.
        recoverable: shape (2,), whether the other end can be recovered from each end's entry.
    """

    xy: Floats
    steps: Ints
    recoverable: Ints


def build_constellation_index(grid: DotGrid) -> ConstellationIndex:
    """Index the smallest constellations around every dot, about sixteen each.

    With sixteen per dot, some remain complete when half of the dots are missing. Their size adapts to the local
    density, so that sparse areas are indexed as well as dense ones.
    """
    rules = index_rules(len(grid.points), grid.cell)
    buckets, entries = list_constellations(grid, 0, len(grid.points), 0, rules)
    starts = np.zeros(rules.buckets + 1, dtype=np.uint32)
    entries = sort_into_buckets(buckets, entries, 0, starts)
    entries.flags.writeable = starts.flags.writeable = False
    return ConstellationIndex(entries, starts, rules.step, rules.longest)


@njit(cache=True)
def list_constellations(
    grid: DotGrid, begin: int, end: int, index_offset: int, rules: IndexRules
) -> tuple[NDArray[np.uint32], NDArray[np.uint64]]:
    """List the constellations of a range of dots, each once: it belongs to the earlier end of its baseline.

    Args:
        grid: the map, or a part of it that extends at least four cells beyond these dots.
        begin: index of the first dot of the range in the grid.
        end: index after the last dot of the range.
        index_offset: number of map dots before the first dot of the grid.
        rules: how the map is indexed.

    Returns:
        buckets, shape (M,), and entries, shape (M,), of the constellations.
    """
    near = _allocate_neighbourhood()
    buffers = _KeyBuffers(np.empty((INNER_DOTS, 2)), np.empty(KEY_SIZE, dtype=np.int64), np.empty(2, dtype=np.int64))
    lune = np.empty(INDEX_LUNE_DOTS_MAX, dtype=np.int64)
    quadruples = np.empty((MAX_QUADRUPLES, INNER_DOTS), dtype=np.int64)
    buckets = np.empty(_INITIAL_CAPACITY * (end - begin) + MAX_QUADRUPLES, dtype=np.uint32)
    entries = np.empty(len(buckets), dtype=np.uint64)
    total = 0
    for first in range(begin, end):
        count = _find_neighbours(grid, first, rules.longest, near)
        for second in range(INNER_DOTS + 1, count):
            if near.dots[second] <= first:
                continue
            inside = _dots_in_lune(near, second, lune)
            if inside == 0:
                continue
            length = math.sqrt(near.squared[second])
            found = list_quadruples(near.points, lune[:inside], length, quadruples)
            if total + found > len(buckets):
                buckets = np.concatenate((buckets, np.empty_like(buckets)))
                entries = np.concatenate((entries, np.empty_like(entries)))
            chosen = quadruples[: found : rules.stride] if inside == INDEX_LUNE_DOTS_MAX else quadruples[:found]
            total = _add_entries(grid, near, second, chosen, index_offset, rules, buffers, buckets, entries, total)
    return buckets[:total].copy(), entries[:total].copy()


@njit(cache=True)
def _allocate_neighbourhood() -> Neighbourhood:
    dots, candidates = np.empty(_NEIGHBOURS, np.int64), np.empty(_NEIGHBOURS, np.int64)
    x, y, squared = np.zeros(_NEIGHBOURS), np.zeros(_NEIGHBOURS), np.zeros(_NEIGHBOURS)
    return Neighbourhood(dots, np.zeros((_NEIGHBOURS, 2)), x, y, squared, candidates)


@njit(cache=True)
def _add_entries(
    grid: DotGrid,
    neighbourhood: Neighbourhood,
    second: int,
    quadruples: Ints,
    index_offset: int,
    rules: IndexRules,
    buffers: _KeyBuffers,
    buckets: NDArray[np.uint32],
    entries: NDArray[np.uint64],
    total: int,
) -> int:
    """Append the constellations of one baseline to the ``total`` existing ones and return the new total.

    A baseline is skipped where rounding makes its other end unrecoverable because another dot is too close.
    """
    if len(quadruples) == 0:
        return total
    steps = buffers.steps
    x, y = neighbourhood.x[second], neighbourhood.y[second]
    ends = neighbourhood.dots[0], neighbourhood.dots[second]
    packed_baselines = pack_baseline(x, y, rules.longest), pack_baseline(-x, -y, rules.longest)
    recoverable = buffers.recoverable
    recoverable[:] = _UNCHECKED
    for inner_dots in quadruples:
        swapped = _quantize_key(neighbourhood.points, second, inner_dots, rules.step, buffers.xy, steps)
        if recoverable[swapped] == _UNCHECKED:
            other_end = second_dot_of_entry(grid, packed_baselines[swapped], ends[swapped], rules.longest)
            recoverable[swapped] = _RECOVERABLE if other_end == ends[1 - swapped] else _UNRECOVERABLE
        if recoverable[swapped] == _RECOVERABLE:
            buckets[total] = bucket_of_hash(hash_cell(steps), rules.buckets)
            entries[total] = pack_entry(pack_subcell(steps), packed_baselines[swapped], ends[swapped] + index_offset)
            total += 1
    return total


@njit(cache=True)
def sort_into_buckets(
    buckets: NDArray[np.uint32], entries: NDArray[np.uint64], first_bucket: int, starts: NDArray[np.uint32]
) -> NDArray[np.uint64]:
    """Return entries bucket by bucket, in stable order (a counting sort).

    Args:
        buckets: shape (m,), bucket of each entry, all within the range of ``starts``.
        entries: shape (m,), packed constellations.
        first_bucket: first bucket of ``starts``.
        starts: shape (b + 1,), zeros; output: first entry of each bucket.
    """
    # Counted one element ahead: filling a bucket moves its begin to its end, which is the begin of the next one.
    begins = starts[1:]
    for bucket in buckets:
        begins[bucket - first_bucket] += np.uint32(1)
    total = np.uint32(0)
    for bucket in range(len(begins)):
        count = begins[bucket]
        begins[bucket] = total
        total += count
    ordered = np.empty_like(entries)
    for i in range(len(entries)):
        bucket = buckets[i] - first_bucket
        ordered[begins[bucket]] = entries[i]
        begins[bucket] += np.uint32(1)
    return ordered


@njit(cache=True)
def _find_neighbours(grid: DotGrid, first: int, radius: float, neighbourhood: Neighbourhood) -> int:
    """Write a dot and its neighbours, nearest first, and return their number."""
    x, y = np.float64(grid.points[first, 0]), np.float64(grid.points[first, 1])
    dots, xs, ys, squared = neighbourhood.dots, neighbourhood.x, neighbourhood.y, neighbourhood.squared
    candidates = neighbourhood.candidates[: dots_within(grid, x, y, radius, neighbourhood.candidates)]
    dots[0] = first
    filled = 1
    for dot in candidates:
        if dot == first:
            continue
        dx, dy = np.float64(grid.points[dot, 0]) - x, np.float64(grid.points[dot, 1]) - y
        distance = dx * dx + dy * dy
        k = filled
        while k > 1 and squared[k - 1] > distance:
            dots[k], squared[k], xs[k], ys[k] = dots[k - 1], squared[k - 1], xs[k - 1], ys[k - 1]
            k -= 1
        dots[k], squared[k], xs[k], ys[k] = dot, distance, dx, dy
        filled += 1
    neighbourhood.points[:, 0], neighbourhood.points[:, 1] = xs, ys
    return filled


@njit(cache=True)
def _dots_in_lune(neighbourhood: Neighbourhood, second: int, lune: Ints) -> int:
    """Write the dots in the lune of the baseline from the centre dot to ``second`` and return their number.

    Returns 0 if the baseline is not indexed. As the dots are sorted by distance, only those before ``second`` are
    candidates. Most baselines have too many dots in their lune; counting first, without branches, is much faster.
    """
    x, y, max_squared = neighbourhood.x[second], neighbourhood.y[second], neighbourhood.squared[second]
    inside = 0
    for k in range(1, second):
        dx, dy = neighbourhood.x[k] - x, neighbourhood.y[k] - y
        inside += dx * dx + dy * dy <= max_squared
    if inside < INNER_DOTS or inside > INDEX_LUNE_DOTS_MAX:
        return 0
    found = 0
    for k in range(1, second):
        dx, dy = neighbourhood.x[k] - x, neighbourhood.y[k] - y
        if dx * dx + dy * dy <= max_squared:
            lune[found] = k
            found += 1
    return inside


@njit(cache=True)
def _quantize_key(points: Floats, second: int, inner_dots: Ints, step: float, xy: Floats, steps: Ints) -> int:
    """Write the canonical key of one constellation to ``steps``; return 1 if the ends were swapped, else 0.

    In a canonical key the inner dots are on average closer to its first end, which is dot 0.
    """
    baseline_coordinates(points, np.int64(0), second, inner_dots, xy)
    swapped = 1 if mean_x_offset(xy) > 0.0 else 0
    if swapped:
        swap_ends(xy)
    sort_by_x(xy)
    quantize_coordinates(xy, step, steps)
    return swapped
