"""An indexed map contains all dots and is read-only."""

from __future__ import annotations

import numpy as np
import pytest
from floor_views import DENSITY

from floor_localizer.core.constellation.index_format import first_dot_of_entry
from floor_localizer.core.constellation.indexed_map import is_occupied


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
