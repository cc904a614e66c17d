"""Walks and routes by the reward rule."""

import numpy as np
import pytest
from grid_maps import GRID_MAPS, maze
from grid_world import distances_from, is_traversable

from reward_planner.core.reward.reward_walk import RewardWalk, reward_route
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import RewardSettings


def go(blocked, start, goal, settings, steps_max=3000) -> list[tuple[int, int]]:
    walk = RewardWalk(blocked.shape, start, goal, settings)
    cells = [start]
    while not walk.is_at_goal and len(cells) < steps_max and walk.advance(blocked):
        cells.append(walk.cell)
    return cells


@pytest.mark.parametrize('visits', ['once', 'counted'])
@pytest.mark.parametrize('kind', GRID_MAPS)
def test_no_sum_makes_the_robot_enter_an_occupied_cell(kind: str, visits: str) -> None:
    blocked = GRID_MAPS[kind](40, 4)
    start, goal = (tuple(c) for c in np.random.default_rng(1).permutation(np.argwhere(~blocked))[:2].tolist())
    cells = go(blocked, start, goal, RewardSettings(visits=visits, virtual_steps_max=500), steps_max=500)
    assert is_traversable(blocked, np.array(cells))


def test_far_from_the_goal_where_a_collision_scores_best_it_is_still_not_taken() -> None:
    blocked = np.zeros((3, 3000), dtype=bool)
    blocked[1, 1] = True
    cells = go(blocked, (1, 0), (1, 2999), RewardSettings(), steps_max=50)
    assert is_traversable(blocked, np.array(cells))


@pytest.mark.parametrize('visits', ['once', 'counted'])
def test_counted_visits_leave_a_trap_that_one_penalty_does_not(visits: str) -> None:
    trap = np.zeros((30, 30), dtype=bool)
    trap[4:26, 20] = trap[4, 4:21] = trap[25, 4:21] = True
    greedy = go(trap, (15, 15), (15, 27), RewardSettings(visits=visits, virtual_steps_max=0))
    assert (greedy[-1] == (15, 27)) == (visits == 'counted')


def test_the_virtual_search_goes_around_the_shorter_side() -> None:
    wall = np.zeros((40, 40), dtype=bool)
    wall[8:22, 20] = True
    shortest = distances_from(wall, (15, 10))[15, 30]
    cells = go(wall, (15, 10), (15, 30), RewardSettings(visits='counted'))
    assert cells[-1] == (15, 30)
    assert len(cells) < 1.5 * shortest


def test_a_robot_that_is_walled_in_says_so() -> None:
    blocked = np.ones((3, 3), dtype=bool)
    blocked[1, 1] = False
    walk = RewardWalk((3, 3), (1, 1), (0, 0), RewardSettings())
    assert not walk.advance(blocked)
    assert walk.cell == (1, 1)


FREE = np.zeros((30, 40), dtype=bool)
COUNTED = RewardSettings(visits='counted')


def test_the_way_is_the_shortest_where_nothing_hinders():
    route = reward_route(FREE, (3, 3), (3, 30), COUNTED)
    assert route.length == 27.0
    assert is_traversable(FREE, route.cells)
    cells = go(np.zeros((30, 30), dtype=bool), (3, 4), (20, 27), RewardSettings())
    assert cells[-1] == (20, 27)
    assert len(cells) == 1 + 23


def test_a_partial_route_is_the_start_of_the_whole_route():
    whole = reward_route(FREE, (3, 3), (20, 30), COUNTED)
    piece = reward_route(FREE, (3, 3), (20, 30), COUNTED, steps_max=8)
    np.testing.assert_array_equal(piece.cells, whole.cells[: len(piece.cells)])
    assert len(piece.cells) == 9


def test_where_the_robot_was_it_does_not_go_again():
    visited = [(3, column) for column in range(10, 20)]
    route = reward_route(FREE, (3, 3), (3, 30), COUNTED, np.array(visited))
    assert not {tuple(cell) for cell in route.cells.tolist()} & set(visited)
    walk = RewardWalk(FREE.shape, (3, 3), (3, 30), RewardSettings())
    assert walk.advance(FREE)
    back = {reward.step: reward.terms for reward in walk.explain(FREE)}
    assert [step for step, terms in back.items() if 'visited' in terms] == [(0, -1)]


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


def test_a_rule_that_goes_around_gives_up_and_says_so():
    walls = maze(61, 2, corridor=3)
    greedy = RewardSettings(virtual_steps_max=0)
    assert reward_route(walls, (2, 2), (58, 58), greedy) is NoRoute.GAVE_UP
