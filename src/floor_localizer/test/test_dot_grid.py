"""The grid compared to scipy's k-d tree, and densities compared to those of the generated floors."""

import math

import numpy as np
import pytest
from floor_views import random_floor
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.dot_grid import (
    build_dot_grid,
    dots_within,
    nearest_dot,
    pair_density,
    typical_spacing,
)

FLOORS = {
    'even': lambda rng: rng.uniform((-1.0, 2.0), (0.0, 2.5), (700, 2)),
    'clustered': lambda rng: np.repeat(rng.uniform(0.0, 2.0, (20, 2)), 15, 0) + rng.normal(0.0, 0.01, (300, 2)),
    'one row': lambda rng: np.column_stack([rng.uniform(0.0, 1.0, 50), np.zeros(50)]),
    'one dot': lambda rng: np.array([[3.0, -4.0]]),
}


@pytest.fixture(params=FLOORS)
def points(request):
    return FLOORS[request.param](np.random.default_rng(3)).astype(np.float32).astype(np.float64)


def test_order_leads_from_given_dots_to_those_of_the_grid(points):
    grid, order = build_dot_grid(points)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(points)))
    np.testing.assert_array_equal(grid.points, points[order])


def test_every_dot_is_in_its_own_cell(points):
    grid, _ = build_dot_grid(points)
    cells = np.repeat(np.arange(grid.rows * grid.columns), np.diff(grid.starts))
    column, row = np.floor((grid.points - (grid.x0, grid.y0)) / grid.cell + 1e-4).astype(int).T
    off = np.abs(row * grid.columns + column - cells)
    # Rounded to single precision, a dot on a cell's border may be in the next cell.
    assert np.mean(off != 0) <= 0.01


def test_memory_is_bounded_however_sparse_the_dots_are():
    points = np.vstack([np.random.default_rng(0).uniform(0.0, 0.1, (100, 2)), [[50.0, 80.0]]])
    grid, _ = build_dot_grid(points)
    assert len(grid.starts) < 40 * len(points)
    assert nearest_dot(grid, 50.0, 80.0, 0.001)[0] >= 0


@pytest.mark.parametrize('reach', [0.002, 0.02, 0.3])
def test_nearest_dot_is_the_one_a_tree_finds(points, reach):
    rng = np.random.default_rng(5)
    grid, _ = build_dot_grid(points)
    tree = cKDTree(grid.points.astype(np.float64))
    middle = points.mean(axis=0)
    near = points[:20] + rng.normal(0.0, 0.003, points[:20].shape)
    places = np.vstack([near, middle + rng.normal(0, 1, (80, 2))])
    for place in places:
        distance, nearest = tree.query(place)
        found, squared = nearest_dot(grid, *place, reach)
        if distance > reach:
            assert found == -1
        else:
            assert found == nearest
            assert math.sqrt(squared) == pytest.approx(distance, abs=1e-9)


def test_dots_within_are_those_a_tree_finds(points):
    grid, _ = build_dot_grid(points)
    tree = cKDTree(grid.points.astype(np.float64))
    found = np.empty(len(points), dtype=np.int64)
    for place in points[:25]:
        count = dots_within(grid, *place, 0.05, found)
        assert set(found[:count]) == set(tree.query_ball_point(place, 0.05))


def test_dots_within_leaves_out_what_does_not_fit_and_far_outside_there_is_none():
    grid, _ = build_dot_grid(random_floor(2, (0.2, 0.2)).points)
    found = np.empty(5, dtype=np.int64)
    assert dots_within(grid, 0.1, 0.1, 0.1, found) == 5
    assert len(set(found)) == 5
    for x, y in [(-9.0, 0.1), (9.0, 0.1), (0.1, -9.0), (0.1, 9.0)]:
        assert nearest_dot(grid, x, y, 0.5)[0] == -1
        assert dots_within(grid, x, y, 0.5, found) == 0


def poisson_points(rng, density, size):
    return rng.uniform(0.0, size, (rng.poisson(density * size * size), 2))


@pytest.mark.parametrize('density', [200.0, 5384.0])
def test_spacing_and_pair_density_of_an_even_floor_are_those_of_its_density(density):
    points = poisson_points(np.random.default_rng(8), density, math.sqrt(3000 / density))
    assert typical_spacing(points) == pytest.approx(1.0 / math.sqrt(density), rel=0.05)
    assert typical_spacing(points * 37.0) == pytest.approx(37.0 * typical_spacing(points), rel=1e-6)
    assert pair_density(build_dot_grid(points)[0]) == pytest.approx(density, rel=0.1)


def test_pair_density_is_higher_where_dots_crowd_together():
    rng = np.random.default_rng(9)
    even = poisson_points(rng, 1000.0, 1.6)
    heaps = rng.uniform(0.0, 1.6, (len(even) // 25, 2)).repeat(25, axis=0)
    heaped = heaps + rng.normal(0.0, 0.01, heaps.shape)
    assert pair_density(build_dot_grid(heaped)[0]) > 1.5 * pair_density(build_dot_grid(even)[0])


def test_two_rooms_far_apart_are_as_dense_as_one():
    rng = np.random.default_rng(10)
    room = poisson_points(rng, 2000.0, 1.0)
    rooms = np.vstack([room, np.add(poisson_points(rng, 2000.0, 1.0), (9.0, 6.0))])
    assert typical_spacing(rooms) == pytest.approx(typical_spacing(room), rel=0.1)
    assert pair_density(build_dot_grid(rooms)[0]) == pytest.approx(2000.0, rel=0.15)
