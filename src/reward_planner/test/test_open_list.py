"""Tests of the open list."""

import numpy as np

from reward_planner.core.route.shortest_route import pop_first, push


def test_cells_come_out_in_the_order_of_their_keys() -> None:
    rng = np.random.default_rng(3)
    values = rng.integers(0, 50, 300)
    keys, cells = np.empty(300, np.int64), np.empty(300, np.int32)
    for size, value in enumerate(values):
        push(keys, cells, size, value, value + 1000)
    came = []
    for size in range(300, 0, -1):
        came.append(keys[0])
        assert cells[0] == keys[0] + 1000
        pop_first(keys, cells, size)
    assert came == sorted(values)
