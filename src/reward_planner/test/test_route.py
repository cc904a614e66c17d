"""Routes: octile lengths and reachability."""

import math

import numpy as np
import pytest

from reward_planner.core.route.route import DIAGONAL, STRAIGHT, Route, is_reachable, octile_distance, route_length
from reward_planner.core.route.shortest_route import shortest_route


def test_units_are_octile_lengths() -> None:
    for rows, columns in ((0, 0), (3, 0), (-2, 5), (7, 7), (100, -31)):
        low, high = sorted((abs(rows), abs(columns)))
        length = high - low + low * math.sqrt(2.0)
        assert octile_distance(10, 20, 10 + rows, 20 + columns) / STRAIGHT == pytest.approx(length, abs=1e-9)


def test_sums_of_steps_are_ordered_as_their_true_lengths() -> None:
    from fractions import Fraction  # noqa: PLC0415

    rng = np.random.default_rng(0)
    for _ in range(2000):
        diagonal = int(rng.integers(1, STRAIGHT))
        straight = math.isqrt(2 * diagonal * diagonal) + int(rng.integers(2))  # the nearest there is
        is_longer = Fraction(straight) ** 2 > 2 * Fraction(diagonal) ** 2
        assert (straight * STRAIGHT > diagonal * DIAGONAL) == is_longer


def test_a_route_is_as_long_as_its_steps() -> None:
    cells = np.array([[0, 0], [1, 1], [1, 2], [0, 3], [0, 3 - 1]])
    assert Route(cells).length == route_length(cells) == pytest.approx(2.0 + 2.0 * math.sqrt(2.0))
    assert route_length(cells[:1]) == 0.0


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
    touching = np.array([[False, True], [True, False]])
    assert not is_reachable(touching, (0, 0), (1, 1))
