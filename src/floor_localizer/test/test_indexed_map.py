"""An indexed map contains all dots and is read-only."""

import numpy as np
import pytest
from floor_views import DENSITY, random_floor
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.index_format import first_dot_of_entry
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


def test_indexed_map_holds_every_dot(floor, indexed_floor):
    found = indexed_floor.grid.points
    np.testing.assert_allclose(
        found[np.lexsort(found.T)], floor.points[np.lexsort(floor.points.astype(np.float32).T)], atol=1e-6
    )


def test_density_is_that_of_the_floor(indexed_floor):
    assert indexed_floor.density == pytest.approx(DENSITY, rel=0.1)


def test_baseline_ends_are_dots_of_the_map(floor, indexed_floor):
    assert max(first_dot_of_entry(np.uint64(entry)) for entry in indexed_floor.index.entries) < len(floor)


def test_occupancy_is_that_of_the_map(floor, indexed_floor):
    assert all(is_occupied(indexed_floor.addresses, x, y) for x, y in floor.points[:200])


def test_nothing_of_it_can_be_written(indexed_floor):
    arrays = [*indexed_floor.grid, *indexed_floor.index, *indexed_floor.addresses]
    assert not any(array.flags.writeable for array in arrays if isinstance(array, np.ndarray))
