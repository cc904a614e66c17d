"""Successors of jump points."""

import numpy as np

from reward_planner.core.route.bit_grid import pack_grid
from reward_planner.core.route.jump_points import successors, successors_of_start

FOUND = np.empty((200, 2), np.int32)


def test_in_the_open_a_start_leads_to_nothing_but_the_goal() -> None:
    grid = pack_grid(np.zeros((20, 20), dtype=bool))
    count = successors_of_start(grid, 5, 5, (9, 15), FOUND)
    assert {tuple(place) for place in FOUND[:count].tolist()} == {(9, 15)}


def test_past_the_end_of_a_wall_the_way_turns_behind_it() -> None:
    blocked = np.zeros((20, 20), dtype=bool)
    blocked[6, :10] = True
    grid = pack_grid(blocked)
    behind = (7, 3)
    count = successors_of_start(grid, 5, 2, behind, FOUND)
    assert [5, 10] in FOUND[:count].tolist()
    count = successors(grid, 5, 10, (5, 2), behind, FOUND)
    assert [7, 10] in FOUND[:count].tolist()
    count = successors(grid, 7, 10, (5, 10), behind, FOUND)
    assert list(behind) in FOUND[:count].tolist()
