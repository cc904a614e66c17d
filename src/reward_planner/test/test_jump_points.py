"""Jump points and successors."""

import numpy as np
import pytest

from reward_planner.core.route.jump_points import (
    is_blocked,
    jump_along_column,
    jump_along_row,
    jump_diagonally,
    pack_grid,
    successors,
    successors_of_start,
)

BLOCKED = np.random.default_rng(4).random((70, 90)) < 0.15
GRID = pack_grid(BLOCKED)
GOAL = (33, 44)


def around(row: int, column: int) -> bool:
    inside = 0 <= row < 70 and 0 <= column < 90
    return not inside or bool(BLOCKED[row, column])


def walk(row: int, column: int, down: int, right: int) -> tuple[int, int] | None:
    """Go straight until an adjacent wall ends, or to the goal."""
    while True:
        row, column = row + down, column + right
        if around(row, column):
            return None
        sides = [(right, down), (-right, -down)]
        if (row, column) == GOAL or any(
            around(row + a - down, column + b - right) and not around(row + a, column + b) for a, b in sides
        ):
            return row, column


def test_every_cell_and_the_border_is_seen_as_it_is() -> None:
    for row, column in np.ndindex(72, 92):
        assert is_blocked(GRID, row - 1, column - 1) == around(row - 1, column - 1)


def test_straight_jumps_end_where_a_walk_does() -> None:
    for row, column in np.argwhere(~BLOCKED)[::7].tolist():
        for turn in (-1, 1):
            along_row, along_column = walk(row, column, 0, turn), walk(row, column, turn, 0)
            assert jump_along_row(GRID, row, column, turn, *GOAL) == (along_row[1] if along_row else -1)
            assert jump_along_column(GRID, row, column, turn, *GOAL) == (along_column[0] if along_column else -1)


@pytest.mark.parametrize('turns', [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_a_diagonal_gives_what_its_rows_and_columns_lead_to(turns: tuple[int, int]) -> None:
    down, right = turns
    found = np.empty((300, 2), np.int32)
    for begin in np.argwhere(~BLOCKED)[::11].tolist():
        row, column = begin
        expected = []
        while not any(around(row + a, column + b) for a, b in ((down, 0), (0, right), (down, right))):
            row, column = row + down, column + right
            if (row, column) == GOAL:
                expected.append(GOAL)
                break
            expected += filter(None, (walk(row, column, 0, right), walk(row, column, down, 0)))
        count = jump_diagonally(GRID, *begin, turns, GOAL, found, 0)
        assert sorted(map(tuple, found[:count].tolist())) == sorted(expected)


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
    for cell, parent, then in (((5, 10), (5, 2), [7, 10]), ((7, 10), (5, 10), list(behind))):
        count = successors(grid, *cell, parent, behind, FOUND)
        assert then in FOUND[:count].tolist()
