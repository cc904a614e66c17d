"""Tests of the virtual search."""

import math

import numpy as np
import pytest

from reward_planner.core.reward.reward_walk import best_steps, choose_step, virtual_path_length
from reward_planner.core.reward.step_reward import STEPS, RewardRule
from reward_planner.core.route.route import STRAIGHT
from reward_planner.core.settings import RewardTable

RULE = RewardRule((4, 7), RewardTable().reward_values(), is_counted=True)


def test_the_best_two_steps_are_those_with_the_highest_sums_that_can_be_taken() -> None:
    terms = np.zeros((8, 5))
    terms[:, 0] = [3.0, 9.0, 5.0, 1.0, 8.0, 0.0, 2.0, 4.0]
    terms[1, 1] = -1000.0
    assert best_steps(terms) == (4, 2)
    terms[:, 2] = -1000.0
    assert best_steps(terms) == (-1, -1)


def test_a_virtual_path_has_its_length_and_leaves_no_visits_behind() -> None:
    free, visits = np.zeros((9, 9), dtype=bool), np.zeros((9, 9), dtype=np.int32)
    right, up_right = (int(np.flatnonzero((step == STEPS).all(axis=1))[0]) for step in ((0, 1), (1, 1)))
    for step, expected in ((right, 5.0), (up_right, 3.0 + 2.0 * math.sqrt(2.0))):
        length = virtual_path_length(RULE, free, visits, (4, 2, True), step, 100)
        assert length / STRAIGHT == pytest.approx(expected)
    assert not visits.any()


def test_a_virtual_path_that_does_not_arrive_has_no_length() -> None:
    split = np.zeros((9, 9), dtype=bool)
    split[:, 5] = True
    visits = np.zeros((9, 9), dtype=np.int32)
    assert virtual_path_length(RULE, split, visits, (4, 2, True), 0, 200) == -1
    assert not visits.any()


@pytest.mark.parametrize('side', [-1, 1])
def test_of_two_equal_steps_the_one_with_the_shorter_virtual_path_is_taken(side: int) -> None:
    """Figure 3: a wall ahead ends nearer on one side; greedy steps do not know it, paths (a) and (b) do."""
    wall, rule = np.zeros((41, 21), dtype=bool), RULE._replace(goal=(20, 16))
    wall[20 - 2 - (side > 0) * 3 : 20 + 3 + (side < 0) * 3, 10] = True
    visits = np.zeros(wall.shape, dtype=np.int32)
    visits[20, 9] = 1
    chosen = choose_step(rule, wall, visits, (20, 9, True), 1000)
    greedy = choose_step(rule, wall, visits, (20, 9, True), 0)
    assert STEPS[chosen].tolist() == [side, 0]
    assert STEPS[greedy].tolist() == [1, 0]
