"""Tests of the rewards of single steps against Table 1 written out by hand."""

import math

import numpy as np
import pytest

from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.reward.step_reward import StepReward
from reward_planner.core.settings import RewardSettings, RewardTable

FREE = np.zeros((20, 20), dtype=bool)


def rewards(blocked, start, goal, visits='once', steps=0) -> dict[tuple[int, int], StepReward]:
    walk = RewardWalk(blocked.shape, start, goal, RewardSettings(visits=visits, virtual_steps_max=0))
    for _ in range(steps):
        assert walk.advance(blocked)
    return {reward.step: reward for reward in walk.explain(blocked)}


def test_a_free_step_earns_100_over_l_less_l() -> None:
    for (rows, columns), reward in rewards(FREE, (5, 5), (5, 15)).items():
        distance = math.hypot(5 + rows - 5, 5 + columns - 15)
        assert reward.terms['advance'] == pytest.approx(100.0 / distance - distance)
        assert reward.can_enter


@pytest.mark.parametrize(('goal', 'step'), [((15, 15), (1, 1)), ((5, 6), (0, 1))])
def test_the_best_step_is_first_and_goes_to_the_goal(goal, step) -> None:
    explained = RewardWalk(FREE.shape, (5, 5), goal, RewardSettings()).explain(FREE)
    assert explained[0].step == step
    assert [r.total for r in explained] == sorted((r.total for r in explained), reverse=True)


def test_steps_into_obstacles_past_corners_and_off_the_map_cost_1000_and_cannot_be_taken() -> None:
    blocked = FREE.copy()
    blocked[0, 6] = True
    found = rewards(blocked, (0, 5), (10, 10))
    assert found[0, 1].terms == {'collision': -1000.0}
    assert found[1, 1].terms == {'collision': -1000.0}
    assert found[-1, 0].terms == {'outside': -1000.0}
    assert not any(found[step].can_enter for step in [(0, 1), (1, 1), (-1, 0), (-1, 1), (-1, -1)])


def test_the_way_back_costs_250_however_often_it_was_gone_or_each_time() -> None:
    pocket = np.ones((4, 5), dtype=bool)
    pocket[1, 1:4] = False
    for visits, worst in (('once', 1), ('counted', 2)):
        back = rewards(pocket, (1, 1), (3, 3), visits, steps=5)
        assert min(r.terms.get('visited', 0.0) for r in back.values()) == -250.0 * worst


def test_only_a_second_step_off_the_straight_way_is_a_detour() -> None:
    wall = FREE.copy()
    wall[2:18, 10] = True
    goal = (9, 15)
    assert not any('detour' in r.terms for r in rewards(wall, (9, 8), goal).values())
    after_one = rewards(wall, (9, 9), goal, steps=1)
    assert sum('detour' in r.terms for r in after_one.values()) >= 4
    assert {r.terms['detour'] for r in after_one.values() if 'detour' in r.terms} == {-100.0}


def test_the_table_is_that_of_the_paper() -> None:
    assert RewardTable().reward_values().tolist() == [100.0, -1000.0, -1000.0, -250.0, -100.0]
