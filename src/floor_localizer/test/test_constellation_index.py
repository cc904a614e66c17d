"""Every constellation is found under its own key, whatever the order of the dots."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from floor_views import random_floor

from floor_localizer.core.constellation.constellation_index import (
    MOST_INDEXED,
    build_constellation_index,
)
from floor_localizer.core.constellation.constellation_key import (
    base_coordinates,
    bucket_of_hash,
    hash_of_code,
    imbalance,
    lane_hashes,
    pack_coordinates,
    sort_by_x,
    turn_around,
)
from floor_localizer.core.constellation.dot_grid import build_dot_grid

SIZE = (0.2, 0.15)


@pytest.fixture(scope='module')
def grid():
    return build_dot_grid(random_floor(6, SIZE).points)[0]


@pytest.fixture(scope='module')
def index(grid):
    return build_constellation_index(grid)


def key_of(points, first, second, others):
    """The key in canonical order, and the base in the order that it has there."""
    xy = np.empty((4, 2))
    base_coordinates(points, first, second, np.array(others), xy)
    swapped = imbalance(xy) > 0.0
    if swapped:
        turn_around(xy)
    sort_by_x(xy)
    return int(pack_coordinates(xy)), (second, first) if swapped else (first, second)


def constellations(points, longest):
    """All constellations of a small map by plain search: keys and bases."""
    gaps = np.linalg.norm(points[:, None] - points, axis=2)
    for i, j in itertools.combinations(range(len(points)), 2):
        base = gaps[i, j]
        if base > longest:
            continue
        lens = [k for k in np.flatnonzero((gaps[i] <= base) & (gaps[j] <= base)) if k not in (i, j)]
        if not 4 <= len(lens) <= MOST_INDEXED:
            continue
        for others in itertools.combinations(lens, 4):
            if all(gaps[k, m] <= base for k, m in itertools.combinations(others, 2)):
                yield key_of(points, i, j, others)


def test_index_holds_the_constellations_that_plain_search_finds(grid, index):
    points = grid.points.astype(np.float64)
    # The key of a coordinate on the edge of two steps hangs on the last bit; bases do not.
    expected = sorted(tuple(sorted(base)) for _, base in constellations(points, index.reach * (1.0 + 1e-9)))
    assert sorted(tuple(sorted(base)) for base in index.bases.tolist()) == expected


def test_every_constellation_is_found_in_the_bucket_of_its_own_key(grid, index):
    points = grid.points.astype(np.float64)
    table = lane_hashes(index.x_cell, index.y_cell)
    missed = total = 0
    for key, base in constellations(points, index.reach):
        bucket = bucket_of_hash(np.uint64(hash_of_code(np.uint64(key), table)), index.bits)
        entries = range(index.starts[bucket], index.starts[bucket + 1])
        total += 1
        missed += not any(
            int(index.codes[e]) == key and tuple(index.bases[e].tolist()) == base for e in entries
        )
    assert total > 1000
    assert missed <= 0.001 * total


def test_buckets_cover_the_index_once(index):
    assert index.starts[0] == 0
    assert index.starts[-1] == len(index.codes) == len(index.bases)
    assert np.all(np.diff(index.starts.astype(np.int64)) >= 0)


def test_there_are_about_sixteen_constellations_a_dot(grid, index):
    assert 8 < len(index.codes) / len(grid.points) < 24


def test_longest_base_is_the_reach(grid, index):
    ends = grid.points[index.bases].astype(np.float64)
    assert np.max(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)) == pytest.approx(index.reach)


def test_index_does_not_depend_on_the_order_of_the_dots():
    points = random_floor(6, SIZE).points

    def contents(dots):
        grid, _ = build_dot_grid(dots)
        index = build_constellation_index(grid)
        places = grid.points[index.bases].reshape(-1, 4)
        return sorted(zip(index.codes.tolist(), places.tolist()))

    shuffled = np.random.default_rng(0).permutation(points)
    assert contents(shuffled) == contents(points)


def test_index_of_a_larger_floor_of_the_same_shape_is_the_same():
    points = random_floor(6, SIZE).points
    small = build_constellation_index(build_dot_grid(points)[0])
    large = build_constellation_index(build_dot_grid(points * 16.0)[0])
    assert large.reach == pytest.approx(16.0 * small.reach)
    # Powers of two scale numbers exactly.
    np.testing.assert_array_equal(np.sort(large.codes), np.sort(small.codes))


@pytest.mark.parametrize('number', [1, 2, 5])
def test_a_map_of_few_dots_has_an_empty_index(number):
    index = build_constellation_index(build_dot_grid(random_floor(6, SIZE).points[:number])[0])
    assert len(index.codes) == 0
    assert index.starts[-1] == 0
