"""A bit is set if and only if a dot is close."""

from __future__ import annotations

import numpy as np
import pytest
from floor_views import random_floor
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.indexed_map import build_occupancy_bitmap, is_occupied


@pytest.fixture(scope='module')
def grid():
    return build_dot_grid(random_floor(5, (0.3, 0.2)).points)[0]


def test_every_dot_occupies_its_place(grid):
    addresses = build_occupancy_bitmap(grid)
    assert all(is_occupied(addresses, x, y) for x, y in grid.points.astype(np.float64))


def test_a_place_is_occupied_when_a_dot_is_near_and_free_when_none_is(grid):
    addresses = build_occupancy_bitmap(grid)
    places = np.random.default_rng(0).uniform((-0.05, -0.05), (0.35, 0.25), (4000, 2))
    distances, _ = cKDTree(grid.points).query(places)
    occupied = np.array([is_occupied(addresses, *place) for place in places])
    half_diagonal = addresses.block / np.sqrt(2.0)
    reach = 0.15 * grid.cell
    assert np.all(occupied[distances < reach - half_diagonal])
    assert not np.any(occupied[distances > reach + half_diagonal])
    assert np.any(occupied)


def test_far_outside_nothing_is_occupied(grid):
    addresses = build_occupancy_bitmap(grid)
    for x, y in [(-5.0, 0.1), (5.0, 0.1), (0.1, -5.0), (0.1, 5.0)]:
        assert not is_occupied(addresses, x, y)
