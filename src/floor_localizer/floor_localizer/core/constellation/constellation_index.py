"""The index: every small constellation of six map dots, in the bucket of its key."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import (
    LANES,
    OTHERS,
    base_coordinates,
    bucket_of_hash,
    cut_into_steps,
    hash_of_steps,
    imbalance,
    pack_parts,
    sort_by_x,
    turn_around,
)
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.index_entry import base_word, pack_entry, second_of_entry
from floor_localizer.core.constellation.index_rules import IndexRules, index_rules
from floor_localizer.core.constellation.lens import MOST_GROUPS, groups_of_four

# A base is indexed when at most so many dots are in its lens.
MOST_IN_LENS = 6
_NEIGHBOURS = 64
_UNKNOWN, _GOOD, _BAD = 0, 1, 2
# Room for so many constellations a dot is made at first.
_ROOM = 18


class ConstellationIndex(NamedTuple):
    """Constellations of six dots by their key; the arrays may be memory-mapped.

    Attributes:
        entries: shape (M,) uint64, what is kept of each constellation (`index_entry`), bucket by bucket.
        starts: shape (buckets + 1,) uint32, where each bucket begins.
        step: an eighth of a cell's side in units of the base's length.
        longest: no base is longer [m].
    """

    entries: NDArray[np.uint64]
    starts: NDArray[np.uint32]
    step: float
    longest: float


class Surroundings(NamedTuple):
    """A dot and those around it.

    Attributes:
        dots: shape (64,), indices in the grid.
        points: shape (64, 2), from the first dot [m].
        x: shape (64,), the same along x.
        y: shape (64,), along y.
        squared: shape (64,), squared distances from it [m^2].
        near: shape (64,), room to gather them in.
    """

    dots: NDArray[np.int64]
    points: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    squared: NDArray[np.float64]
    near: NDArray[np.int64]


class _KeyRoom(NamedTuple):
    """Room to make the keys of one base in.

    Attributes:
        xy: shape (4, 2), coordinates of the others.
        steps: shape (8,), their steps.
        verdicts: shape (2,), whether the other end is found again from either end.
    """

    xy: NDArray[np.float64]
    steps: NDArray[np.int64]
    verdicts: NDArray[np.int64]


def build_constellation_index(grid: DotGrid) -> ConstellationIndex:
    """Index the smallest constellations around every dot, about sixteen each.

    Few large constellations tell places apart as well as many small ones, and sixteen a dot leave some whole when half
    of the dots are missing. The size follows the density around each dot, so sparse places are indexed like dense ones.
    """
    rules = index_rules(len(grid.points), grid.cell)
    buckets, entries = list_constellations(grid, 0, len(grid.points), 0, rules)
    starts = np.zeros(rules.buckets + 1, dtype=np.uint32)
    entries = sort_into_buckets(buckets, entries, 0, starts)
    entries.flags.writeable = starts.flags.writeable = False
    return ConstellationIndex(entries, starts, rules.step, rules.longest)


@njit(cache=True)
def list_constellations(
    grid: DotGrid, begin: int, end: int, number_before: int, rules: IndexRules
) -> tuple[NDArray[np.uint32], NDArray[np.uint64]]:
    """List the constellations of some dots, each once: of the ends of its base, the earlier one counts.

    Args:
        grid: the map, or a part of it that reaches at least four cells beyond these dots.
        begin: the first of these dots in that grid.
        end: one past the last.
        number_before: dots of the map before the first of the grid.
        rules: how the map is indexed.

    Returns:
        the bucket of each, shape (M,), and what is kept of it, shape (M,).
    """
    around = _room_around()
    room = _KeyRoom(np.empty((OTHERS, 2)), np.empty(LANES, dtype=np.int64), np.empty(2, dtype=np.int64))
    lens = np.empty(MOST_IN_LENS, dtype=np.int64)
    groups = np.empty((MOST_GROUPS, OTHERS), dtype=np.int64)
    buckets = np.empty(_ROOM * (end - begin) + MOST_GROUPS, dtype=np.uint32)
    entries = np.empty(len(buckets), dtype=np.uint64)
    total = 0
    for first in range(begin, end):
        count = _look_around(grid, first, rules.longest, around)
        for second in range(OTHERS + 1, count):
            if around.dots[second] <= first:
                continue
            inside = _dots_in_lens(around, second, lens)
            if inside == 0:
                continue
            length = math.sqrt(around.squared[second])
            found = groups_of_four(around.points, lens[:inside], length, groups)
            if total + found > len(buckets):
                buckets = np.concatenate((buckets, np.empty_like(buckets)))
                entries = np.concatenate((entries, np.empty_like(entries)))
            stride = rules.stride if inside == MOST_IN_LENS else 1
            total = _add_entries(
                grid,
                around,
                second,
                groups[:found:stride],
                number_before,
                rules,
                room,
                buckets,
                entries,
                total,
            )
    return buckets[:total].copy(), entries[:total].copy()


@njit(cache=True)
def _room_around() -> Surroundings:
    dots, near = np.empty(_NEIGHBOURS, np.int64), np.empty(_NEIGHBOURS, np.int64)
    x, y, squared = np.zeros(_NEIGHBOURS), np.zeros(_NEIGHBOURS), np.zeros(_NEIGHBOURS)
    return Surroundings(dots, np.zeros((_NEIGHBOURS, 2)), x, y, squared, near)


@njit(cache=True)
def _add_entries(
    grid: DotGrid,
    around: Surroundings,
    second: int,
    groups: NDArray[np.int64],
    number_before: int,
    rules: IndexRules,
    room: _KeyRoom,
    buckets: NDArray[np.uint32],
    entries: NDArray[np.uint64],
    total: int,
) -> int:
    """Write the constellations of one base behind the ``total`` that are there, and return how many there are then.

    A base of which one end is not found again from the other is left out: another dot is too near.
    """
    if len(groups) == 0:
        return total
    steps = room.steps
    x, y = around.x[second], around.y[second]
    ends = around.dots[0], around.dots[second]
    words = base_word(x, y, rules.longest), base_word(-x, -y, rules.longest)
    verdicts = room.verdicts
    verdicts[:] = _UNKNOWN
    for others in groups:
        swapped = _cut_key(around.points, second, others, rules.step, room.xy, steps)
        if verdicts[swapped] == _UNKNOWN:
            other_end = second_of_entry(grid, words[swapped], ends[swapped], rules.longest)
            verdicts[swapped] = _GOOD if other_end == ends[1 - swapped] else _BAD
        if verdicts[swapped] == _GOOD:
            buckets[total] = bucket_of_hash(hash_of_steps(steps), rules.buckets)
            entries[total] = pack_entry(pack_parts(steps), words[swapped], ends[swapped] + number_before)
            total += 1
    return total


@njit(cache=True)
def sort_into_buckets(
    buckets: NDArray[np.uint32], entries: NDArray[np.uint64], first_bucket: int, starts: NDArray[np.uint32]
) -> NDArray[np.uint64]:
    """Return entries bucket by bucket, those of one bucket in the order in which they came (a counting sort).

    Args:
        buckets: shape (m,), the bucket of each, all within the range of ``starts``.
        entries: shape (m,).
        first_bucket: the bucket that ``starts`` begins with.
        starts: shape (b + 1,), zeros; written: where each bucket begins.
    """
    # The bucket of a key counts one place ahead: filling it moves its beginning to its end, where the next one begins.
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
def _look_around(grid: DotGrid, first: int, widest: float, around: Surroundings) -> int:
    """Write the dots around one, itself first and the others from near to far, and return their number."""
    x, y = np.float64(grid.points[first, 0]), np.float64(grid.points[first, 1])
    dots, xs, ys, squared = around.dots, around.x, around.y, around.squared
    near = around.near[: dots_within(grid, x, y, widest, around.near)]
    dots[0] = first
    filled = 1
    for dot in near:
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
    around.points[:, 0], around.points[:, 1] = xs, ys
    return filled


@njit(cache=True)
def _dots_in_lens(around: Surroundings, second: int, lens: NDArray[np.int64]) -> int:
    """Write the dots in the lens of the base from the middle dot to ``second`` if it is indexed, return their number.

    As the dots are in order, only those before the second are near enough to the first. Most bases have too many dots
    in their lenses, and to count them first takes a fraction of the time: there is nothing to be decided on the way.
    """
    x, y, most = around.x[second], around.y[second], around.squared[second]
    inside = 0
    for k in range(1, second):
        dx, dy = around.x[k] - x, around.y[k] - y
        inside += dx * dx + dy * dy <= most
    if inside < OTHERS or inside > MOST_IN_LENS:
        return 0
    found = 0
    for k in range(1, second):
        dx, dy = around.x[k] - x, around.y[k] - y
        if dx * dx + dy * dy <= most:
            lens[found] = k
            found += 1
    return inside


@njit(cache=True)
def _cut_key(
    points: NDArray[np.float64],
    second: int,
    others: NDArray[np.int64],
    step: float,
    xy: NDArray[np.float64],
    steps: NDArray[np.int64],
) -> int:
    """Write the key of one constellation with its ends so that the others are more on the first one's side.

    Args:
        points: shape (n, 2), dots [m]; the first is one end of the base.
        second: the other end.
        others: shape (4,), the other dots.
        step: side of a step in units of the base's length.
        xy: shape (4, 2), room to work in.
        steps: shape (8,), written.

    Returns:
        1 if the ends changed places in it, else 0.
    """
    base_coordinates(points, np.int64(0), second, others, xy)
    swapped = 1 if imbalance(xy) > 0.0 else 0
    if swapped:
        turn_around(xy)
    sort_by_x(xy)
    cut_into_steps(xy, step, steps)
    return swapped
