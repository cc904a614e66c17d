"""Successors of a jump point, given its parent."""

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
def add_straight_jump_point(
    grid: BitGrid,
    row: int,
    column: int,
    directions: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
    count: int,
) -> int:
    """Append the jump point straight ahead; arguments and result as for `jump_diagonally`, one direction is 0."""
    if directions[0]:
        place = jump_along_column(grid, row, column, directions[0], goal[0], goal[1])
        found[count, 0], found[count, 1] = place, column
    else:
        place = jump_along_row(grid, row, column, directions[1], goal[0], goal[1])
        found[count, 0], found[count, 1] = row, place
    return count + 1 if place >= 0 else count


@njit(cache=True)
def successors_of_start(
    grid: BitGrid, row: int, column: int, goal: tuple[int, int], found: NDArray[np.int32]
) -> int:
    """Find the jump points in all eight directions; return their number."""
    count = 0
    for direction in (-1, 1):
        count = add_straight_jump_point(grid, row, column, (direction, 0), goal, found, count)
        count = add_straight_jump_point(grid, row, column, (0, direction), goal, found, count)
        count = jump_diagonally(grid, row, column, (direction, -1), goal, found, count)
        count = jump_diagonally(grid, row, column, (direction, 1), goal, found, count)
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
    """Find the jump points that follow a jump point.

    Args:
        grid: blocked cells as bits.
        row: row of the jump point.
        column: column of the jump point.
        parent: row and column of the previous jump point; the path from there ends with straight steps.
        goal: row and column of the goal.
        found: output, rows and columns of jump points, shape (n, 2).

    Returns:
        number of jump points.
    """
    rows, columns = row - parent[0], column - parent[1]
    along_row = abs(columns) > abs(rows)
    ahead = (0, 1 if columns > 0 else -1) if along_row else (1 if rows > 0 else -1, 0)
    count = add_straight_jump_point(grid, row, column, ahead, goal, found, 0)
    for direction in (-1, 1):
        side = (direction, 0) if along_row else (0, direction)
        # The adjacent wall ends here, so the cells behind it are reached through this cell only.
        if is_blocked(grid, row + side[0] - ahead[0], column + side[1] - ahead[1]) and not is_blocked(
            grid, row + side[0], column + side[1]
        ):
            count = add_straight_jump_point(grid, row, column, side, goal, found, count)
            diagonal = (ahead[0] + side[0], ahead[1] + side[1])
            count = jump_diagonally(grid, row, column, diagonal, goal, found, count)
    return count
