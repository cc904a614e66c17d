"""An indexed map contains all dots and is read-only."""

import numpy as np
import pytest
from floor_views import DENSITY, random_floor
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.indexed_map import build_occupancy_bitmap, is_occupied


@pytest.fixture(scope='module')
def grid():
    return build_dot_grid(random_floor(5, (0.3, 0.2)).points)[0]


def test_a_place_is_occupied_when_a_dot_is_near_and_free_when_none_is(grid):
    addresses = build_occupancy_bitmap(grid)
    places = np.random.default_rng(0).uniform((-0.05, -0.05), (0.35, 0.25), (4000, 2))
    places[:4] = [(-5.0, 0.1), (5.0, 0.1), (0.1, -5.0), (0.1, 5.0)]
    distances, _ = cKDTree(grid.points).query(places)
    occupied = np.array([is_occupied(addresses, *place) for place in places])
    half_diagonal = addresses.block / np.sqrt(2.0)
    reach = 0.15 * grid.cell
    assert np.all(occupied[distances < reach - half_diagonal])
    assert not np.any(occupied[distances > reach + half_diagonal])
    assert np.any(occupied)


def test_indexed_map_holds_every_dot_and_is_as_dense_as_the_floor(floor, indexed_floor):
    found, expected = indexed_floor.grid.points, floor.points.astype(np.float32)
    np.testing.assert_array_equal(found[np.lexsort(found.T)], expected[np.lexsort(expected.T)])
    assert indexed_floor.density == pytest.approx(DENSITY, rel=0.1)
    assert all(is_occupied(indexed_floor.addresses, x, y) for x, y in found.astype(np.float64))


def test_nothing_of_it_can_be_written(indexed_floor):
    arrays = [*indexed_floor.grid, *indexed_floor.index, *indexed_floor.addresses]
    assert not any(array.flags.writeable for array in arrays if isinstance(array, np.ndarray))
