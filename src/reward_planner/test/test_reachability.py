"""Reachable is what the search finds a route to."""

import numpy as np

from reward_planner.core.route.route import Route, is_reachable
from reward_planner.core.route.shortest_route import shortest_route


def test_reachable_is_what_a_search_reaches():
    told = {True: 0, False: 0}
    for seed in range(200):
        rng = np.random.default_rng(seed)
        blocked = rng.random((15, 15)) < 0.4
        free = np.argwhere(~blocked)
        start, goal = (tuple(free[i].tolist()) for i in rng.choice(len(free), 2, replace=False))
        is_there = isinstance(shortest_route(blocked, start, goal), Route)
        assert is_reachable(blocked, start, goal) == is_there
        told[is_there] += 1
    assert min(told.values()) > 30


def test_no_way_leads_between_two_corners_that_touch():
    blocked = np.array([[False, True], [True, False]])
    assert not is_reachable(blocked, (0, 0), (1, 1))
