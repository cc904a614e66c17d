"""Routes of the reward rule reach the goal, avoid visited cells, and can be planned in parts."""

from __future__ import annotations

import numpy as np

from reward_planner.core.planner_settings import RewardSettings
from reward_planner.core.reward.reward_walk import reward_route
from reward_planner.core.route.route import NoRoute
from scene_simulator.grid_truth import is_traversable

FREE = np.zeros((30, 40), dtype=bool)
COUNTED = RewardSettings(visits='counted')


def test_the_way_is_straight_where_nothing_hinders():
    route = reward_route(FREE, (3, 3), (3, 30), COUNTED)
    assert route.length == 27.0
    assert is_traversable(FREE, route.cells)


def test_a_partial_route_is_the_start_of_the_whole_route():
    whole = reward_route(FREE, (3, 3), (20, 30), COUNTED)
    piece = reward_route(FREE, (3, 3), (20, 30), COUNTED, steps_max=8)
    np.testing.assert_array_equal(piece.cells, whole.cells[: len(piece.cells)])
    assert len(piece.cells) == 9


def test_where_the_robot_was_it_does_not_go_again():
    visited_cells = np.array([(3, column) for column in range(10, 20)])
    route = reward_route(FREE, (3, 3), (3, 30), COUNTED, visited_cells)
    visited = {tuple(cell) for cell in route.cells.tolist()} & {
        tuple(cell) for cell in visited_cells.tolist()
    }
    assert not visited


def test_what_cannot_be_reached_is_reported():
    walls = FREE.copy()
    walls[:, 20] = True
    assert reward_route(walls, (3, 3), (3, 30), COUNTED) == NoRoute.UNREACHABLE


def dead_end():
    """A corridor of one cell that ends before the goal, with its way in at the left."""
    walls = FREE.copy()
    walls[[11, 13], 5:25] = walls[11:14, 24] = True
    return walls


def test_a_partial_route_has_no_loops():
    whole = reward_route(dead_end(), (12, 8), (12, 35), COUNTED)
    assert len(np.unique(whole.cells, axis=0)) < len(whole.cells)
    for steps in range(2, 40):
        piece = reward_route(dead_end(), (12, 8), (12, 35), COUNTED, steps_max=steps)
        assert len(np.unique(piece.cells, axis=0)) == len(piece.cells)
        assert len(piece.cells) == steps + 1 or (piece.cells[-1] == (12, 35)).all()
        assert is_traversable(dead_end(), piece.cells)
