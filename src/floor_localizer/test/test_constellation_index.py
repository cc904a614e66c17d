"""Every constellation is found under its own key, for any order of the dots."""

import itertools
from collections import Counter

import numpy as np
import pytest
from floor_views import random_floor
from six_dots import canonical_key

from floor_localizer.core.constellation.constellation_index import (
    INDEX_LUNE_DOTS_MAX,
    build_constellation_index,
    list_constellations,
    sort_into_buckets,
)
from floor_localizer.core.constellation.constellation_key import bucket_of_hash, hash_cell, pack_subcell
from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.index_format import (
    DOTS_MAX,
    LARGE_MAP,
    first_dot_of_entry,
    index_rules,
    second_dot_of_entry,
    subcell_of_entry,
)
from floor_localizer.core.errors import FloorLocalizerError

SIZE = (0.2, 0.15)


@pytest.fixture(scope='module')
def grid():
    return build_dot_grid(random_floor(6, SIZE).points)[0]


@pytest.fixture(scope='module')
def index(grid):
    return build_constellation_index(grid)


def baseline_of(grid, index, entry):
    entry = np.uint64(entry)
    first = first_dot_of_entry(entry)
    return first, second_dot_of_entry(grid, entry, first, index.longest)


def constellations(points, index):
    """All constellations of a small map by brute force: keys and baselines."""
    gaps = np.linalg.norm(points[:, None] - points, axis=2)
    for i, j in itertools.combinations(range(len(points)), 2):
        base = gaps[i, j]
        if base > index.longest:
            continue
        lens = [k for k in np.flatnonzero((gaps[i] <= base) & (gaps[j] <= base)) if k not in (i, j)]
        if not 4 <= len(lens) <= INDEX_LUNE_DOTS_MAX:
            continue
        for others in itertools.combinations(lens, 4):
            if all(gaps[k, m] <= base for k, m in itertools.combinations(others, 2)):
                steps, _, is_swapped = canonical_key(points, index.step, i, j, *others)
                yield steps, (j, i) if is_swapped else (i, j)


def test_index_holds_the_constellations_of_brute_force_except_with_crowded_ends(grid, index):
    points = grid.points.astype(np.float64)
    # The key of a coordinate on the border of two steps depends on rounding; baselines do not.
    expected = Counter(tuple(sorted(base)) for _, base in constellations(points, index))
    found = Counter(tuple(sorted(baseline_of(grid, index, entry))) for entry in index.entries)
    assert found <= expected
    assert found.total() > 0.97 * expected.total()


def test_every_constellation_is_found_in_the_bucket_of_its_own_key(grid, index):
    points = grid.points.astype(np.float64)
    missed = total = 0
    for steps, base in constellations(points, index):
        bucket = bucket_of_hash(np.uint64(hash_cell(steps)), len(index.starts) - 1)
        entries = index.entries[index.starts[bucket] : index.starts[bucket + 1]]
        total += 1
        missed += not any(
            subcell_of_entry(np.uint64(entry)) == pack_subcell(steps) and baseline_of(grid, index, entry) == base
            for entry in entries
        )
    assert total > 1000
    assert missed <= 0.03 * total


def test_parts_of_a_map_list_together_what_the_whole_lists(grid):
    rules = index_rules(len(grid.points), grid.cell)
    ends = [0, 1, 40, len(grid.points)]
    whole = list_constellations(grid, 0, len(grid.points), 0, rules)
    parts = [list_constellations(grid, begin, end, 0, rules) for begin, end in itertools.pairwise(ends)]
    for k in range(2):
        np.testing.assert_array_equal(np.concatenate([part[k] for part in parts]), whole[k])


def test_a_large_map_is_indexed_by_half_of_the_constellations(grid):
    sparse = index_rules(LARGE_MAP + 1, grid.cell)
    buckets, entries = list_constellations(grid, 0, len(grid.points), 0, sparse)
    _, dense = list_constellations(grid, 0, len(grid.points), 0, index_rules(LARGE_MAP, grid.cell))
    assert 0.4 < len(entries) / len(dense) < 0.6
    assert buckets.max() < sparse.buckets


def test_entries_of_a_bucket_keep_their_order():
    buckets = np.array([7, 5, 7, 6, 5], dtype=np.uint32)
    starts = np.zeros(4, dtype=np.uint32)
    ordered = sort_into_buckets(buckets, np.arange(5, dtype=np.uint64), 5, starts)
    np.testing.assert_array_equal(ordered, [1, 4, 3, 0, 2])
    np.testing.assert_array_equal(starts, [0, 2, 3, 5])


def test_more_dots_than_an_entry_can_name_are_refused():
    index_rules(DOTS_MAX, 0.01)
    with pytest.raises(FloorLocalizerError, match='split it'):
        index_rules(DOTS_MAX + 1, 0.01)


def test_there_are_about_sixteen_constellations_a_dot(grid, index):
    assert 8 < len(index.entries) / len(grid.points) < 24


def contents(dots):
    """The subcells of all keys with the positions of their baselines, sorted."""
    grid, _ = build_dot_grid(dots)
    index = build_constellation_index(grid)
    scale = 1.0 / index.longest
    bases = [grid.points[list(baseline_of(grid, index, entry))].reshape(4) * scale for entry in index.entries]
    parts = [int(subcell_of_entry(np.uint64(entry))) for entry in index.entries]
    return sorted((key, *np.round(base, 4).tolist()) for key, base in zip(parts, bases))


def test_index_depends_neither_on_the_order_of_the_dots_nor_on_the_size_of_the_floor():
    points = random_floor(6, SIZE).points
    expected = contents(points)
    assert contents(np.random.default_rng(0).permutation(points)) == expected
    # Powers of two scale numbers exactly.
    assert contents(points * 16.0) == expected


@pytest.mark.parametrize('number', [1, 2, 5])
def test_a_map_of_few_dots_has_an_empty_index(number):
    index = build_constellation_index(build_dot_grid(random_floor(6, SIZE).points[:number])[0])
    assert len(index.entries) == 0
    assert index.starts[-1] == 0
