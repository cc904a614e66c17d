"""Where a search goes on from a jump point, given how it came there."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.route.bit_grid import BitGrid
from reward_planner.core.route.jump_points import (
    is_blocked,
    jump_along_column,
    jump_along_row,
    jump_diagonally,
)


@njit(cache=True)
def add_straight(
    grid: BitGrid,
    row: int,
    column: int,
    turns: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
    count: int,
) -> int:
    """Add the jump point straight ahead; arguments and result as `jump_diagonally`, one of the turns is 0."""
    if turns[0]:
        place = jump_along_column(grid, row, column, turns[0], goal[0], goal[1])
        found[count, 0], found[count, 1] = place, column
    else:
        place = jump_along_row(grid, row, column, turns[1], goal[0], goal[1])
        found[count, 0], found[count, 1] = row, place
    return count + 1 if place >= 0 else count


@njit(cache=True)
def successors_of_start(
    grid: BitGrid, row: int, column: int, goal: tuple[int, int], found: NDArray[np.int32]
) -> int:
    """Write the jump points in all eight directions and return how many there are."""
    count = 0
    for turn in (-1, 1):
        count = add_straight(grid, row, column, (turn, 0), goal, found, count)
        count = add_straight(grid, row, column, (0, turn), goal, found, count)
        count = jump_diagonally(grid, row, column, (turn, -1), goal, found, count)
        count = jump_diagonally(grid, row, column, (turn, 1), goal, found, count)
    return count


@njit(cache=True)
def successors(
    grid: BitGrid,
    row: int,
    column: int,
    parent: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
) -> int:
    """Write the jump points that follow a jump point.

    Args:
        grid: the bits.
        row: of the jump point.
        column: of the jump point.
        parent: row and column of the one before; the way from there ended with straight steps.
        goal: row and column.
        found: shape (n, 2), takes rows and columns.

    Returns:
        how many there are.
    """
    rows, columns = row - parent[0], column - parent[1]
    along_row = abs(columns) > abs(rows)
    ahead = (0, 1 if columns > 0 else -1) if along_row else (1 if rows > 0 else -1, 0)
    count = add_straight(grid, row, column, ahead, goal, found, 0)
    for turn in (-1, 1):
        side = (turn, 0) if along_row else (0, turn)
        # The wall beside the way ended here, so what is behind it is reached through this cell only.
        if is_blocked(grid, row + side[0] - ahead[0], column + side[1] - ahead[1]) and not is_blocked(
            grid, row + side[0], column + side[1]
        ):
            count = add_straight(grid, row, column, side, goal, found, count)
            diagonal = (ahead[0] + side[0], ahead[1] + side[1])
            count = jump_diagonally(grid, row, column, diagonal, goal, found, count)
    return count
