"""Kernels of D* Lite."""

import numpy as np

from reward_planner.core.route.d_star_lite_kernels import (
    UNREACHED,
    OpenList,
    SearchState,
    apply_changes,
    insert_if_inconsistent,
    key_of,
)
from reward_planner.core.route.route import LETHAL, STRAIGHT

WIDTH = 12


def make_state() -> SearchState:
    costs = np.pad(np.zeros((10, 10), dtype=np.uint8), 1, constant_values=LETHAL).reshape(-1)
    g, rhs = np.full((2, len(costs)), UNREACHED, dtype=np.int64)
    return SearchState(costs, 0, g, rhs, WIDTH, WIDTH + 1)


def filled(state: SearchState, cells: range, size: int) -> OpenList:
    open_list = OpenList(np.empty(size, np.int64), np.empty(size, np.int32), 0)
    for cell in cells:
        state.rhs[cell] = cell * STRAIGHT
        open_list = insert_if_inconsistent(state, open_list, cell, 14, 0)
    return open_list


def test_a_full_open_list_keeps_only_what_still_counts_or_grows() -> None:
    state = make_state()
    open_list = filled(state, range(14, 18), 4)
    state.g[[14, 15, 16]] = state.rhs[[14, 15, 16]]
    state.rhs[20] = STRAIGHT
    open_list = insert_if_inconsistent(state, open_list, 20, 14, 0)
    assert sorted(open_list.cells[: open_list.size].tolist()) == [17, 20]
    assert open_list.keys[0] == key_of(state, 20, 14, 0)
    assert len(open_list.keys) == 4
    open_list = filled(make_state(), range(14, 22), 2)
    assert sorted(open_list.cells[: open_list.size].tolist()) == list(range(14, 22))


def test_of_two_cells_on_equally_long_ways_the_one_nearer_to_the_goal_comes_first() -> None:
    state = make_state()
    start = WIDTH + 9
    state.rhs[WIDTH + 3], state.rhs[WIDTH + 4] = 2 * STRAIGHT, 3 * STRAIGHT
    assert key_of(state, WIDTH + 3, start, 0) < key_of(state, WIDTH + 4, start, 0)


def test_only_cells_that_are_others_now_are_changed() -> None:
    state = make_state()
    cells = np.array([[0, 0], [9, 9], [4, 5]])
    assert apply_changes(state, cells, np.array([LETHAL, 0, 7], dtype=np.uint8)).tolist() == [13, 5 * 12 + 6]
    assert apply_changes(state, cells, np.array([LETHAL, 0, 0], dtype=np.uint8)).tolist() == [5 * 12 + 6]
