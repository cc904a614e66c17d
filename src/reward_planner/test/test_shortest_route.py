"""Shortest routes against the lengths of MovingAI and a reference implementation."""

import os
from pathlib import Path

import numpy as np
import pytest
from grid_maps import GRID_MAPS
from grid_world import distances_from, is_traversable
from movingai_files import load_movingai_map

from reward_planner.core.route.route import NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route

ARENA = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'planner' / 'arena.map'


def assert_routes_are_shortest(blocked, start, goals) -> None:
    truth = distances_from(blocked, start)
    for goal in goals:
        route = shortest_route(blocked, start, goal)
        if np.isinf(truth[goal]):
            assert route == NoRoute.UNREACHABLE
            continue
        assert isinstance(route, Route)
        assert route.length == pytest.approx(truth[goal], abs=1e-9)
        assert shortest_route(blocked, goal, start).length == route.length
        assert (tuple(route.cells[0]), tuple(route.cells[-1])) == (start, goal)
        assert is_traversable(blocked, route.cells)


def free_cells(blocked, rng, count) -> list[tuple[int, int]]:
    return [tuple(cell) for cell in rng.permutation(np.argwhere(~blocked))[:count].tolist()]


@pytest.mark.skipif(not ARENA.is_file(), reason='SHIRUBE_DATA names no planner/arena.map')
def test_lengths_are_those_of_the_scenario_file() -> None:
    blocked = load_movingai_map(ARENA)
    scenarios = np.loadtxt(ARENA.with_suffix('.map.scen'), skiprows=1, usecols=(4, 5, 6, 7, 8))
    assert len(scenarios) == 160
    for *ends, length in scenarios:
        column, row, goal_column, goal_row = map(int, ends)
        route = shortest_route(blocked, (row, column), (goal_row, goal_column))
        assert isinstance(route, Route)
        assert route.length == pytest.approx(length, abs=1e-3)


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('share', [0.1, 0.25, 0.4])
def test_routes_in_small_fields_are_shortest(share: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(10):
        blocked = rng.random(rng.integers(2, 20, 2)) < share
        start, *goals = free_cells(blocked, rng, 30) or [None]
        assert_routes_are_shortest(blocked, start, goals)


@pytest.mark.parametrize('kind', GRID_MAPS)
def test_routes_in_made_up_maps_are_shortest(kind: str) -> None:
    rng = np.random.default_rng(5)
    blocked = GRID_MAPS[kind](200, 3)
    start, *goals = free_cells(blocked, rng, 60)
    assert_routes_are_shortest(blocked, start, goals)


@pytest.mark.parametrize('shape', [(1, 1), (1, 64), (64, 1), (63, 65), (128, 64), (3, 200)])
def test_every_size_of_an_empty_map_is_crossed(shape: tuple[int, int]) -> None:
    blocked = np.zeros(shape, dtype=bool)
    corner = (shape[0] - 1, shape[1] - 1)
    assert_routes_are_shortest(blocked, (0, 0), [corner, (0, corner[1]), (corner[0], 0), (0, 0)])
    assert_routes_are_shortest(blocked, corner, [(0, 0)])


def test_no_corner_is_cut_and_two_walls_that_touch_at_a_corner_let_nobody_through() -> None:
    route = shortest_route(np.array([[0, 1], [0, 0]], dtype=bool), (0, 0), (1, 1))
    assert isinstance(route, Route)
    assert route.cells.tolist() == [[0, 0], [1, 0], [1, 1]]
    assert shortest_route(np.array([[0, 1], [1, 0]], dtype=bool), (0, 0), (1, 1)) == NoRoute.UNREACHABLE


@pytest.mark.parametrize(
    ('start', 'goal', 'reason'),
    [
        ((0, 0), (0, 3), NoRoute.GOAL_OUTSIDE),
        ((0, 0), (-1, 0), NoRoute.GOAL_OUTSIDE),
        ((3, 0), (0, 0), NoRoute.START_OUTSIDE),
        ((1, 1), (0, 0), NoRoute.START_BLOCKED),
        ((0, 0), (1, 1), NoRoute.GOAL_BLOCKED),
        ((1, 1), (1, 1), NoRoute.GOAL_BLOCKED),
    ],
)
def test_ends_that_cannot_be_are_reported(start, goal, reason: NoRoute) -> None:
    blocked = np.zeros((3, 3), dtype=bool)
    blocked[1, 1] = True
    assert shortest_route(blocked, start, goal) == reason


def test_of_equally_long_routes_the_one_that_goes_straight_first_is_taken() -> None:
    route = shortest_route(np.zeros((9, 9), dtype=bool), (0, 0), (3, 8))
    assert isinstance(route, Route)
    assert route.cells[:6].tolist() == [[0, column] for column in range(6)]
