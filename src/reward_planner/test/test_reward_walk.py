"""Tests of walks by the reward rule."""

import numpy as np
import pytest

from reward_planner.core.planner_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from scene_simulator.grid_maps import GRID_MAPS
from scene_simulator.grid_truth import distances_from, is_traversable


def go(blocked, start, goal, settings, steps_max=3000) -> list[tuple[int, int]]:
    walk = RewardWalk(blocked.shape, start, goal, settings)
    cells = [start]
    while not walk.is_at_goal and len(cells) < steps_max and walk.advance(blocked):
        cells.append(walk.cell)
    return cells


def test_in_the_open_the_way_is_the_shortest() -> None:
    free = np.zeros((30, 30), dtype=bool)
    cells = go(free, (3, 4), (20, 27), RewardSettings())
    assert cells[-1] == (20, 27)
    assert len(cells) == 1 + 23


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


def test_counted_visits_leave_a_trap_that_one_penalty_does_not() -> None:
    trap = np.zeros((30, 30), dtype=bool)
    trap[4:26, 20] = trap[4, 4:21] = trap[25, 4:21] = True
    greedy = {
        v: go(trap, (15, 15), (15, 27), RewardSettings(visits=v, virtual_steps_max=0))
        for v in ('once', 'counted')
    }
    assert greedy['once'][-1] != (15, 27)
    assert greedy['counted'][-1] == (15, 27)


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
