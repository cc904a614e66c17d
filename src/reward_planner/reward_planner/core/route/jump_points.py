"""Jump points of a cell, and the successors of a jump point (Harabor and Grastien, AAAI 2011, ICAPS 2014).

Of all shortest paths between two cells only one is followed: diagonal steps first, then straight ones. So the search
turns from straight to diagonal only where an adjacent wall ends. On a diagonal, only the jump points along its rows
and columns are kept.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.route.bit_grid import MARGIN, BitGrid, scan_down, scan_up


@njit(cache=True)
def is_blocked(grid: BitGrid, row: int, column: int) -> bool:
    """Return whether a cell is blocked; the border is."""
    place = column + MARGIN
    return (grid.rows[row + 1, place >> 6] >> np.uint64(place & 63)) & np.uint64(1) != np.uint64(0)


@njit(cache=True)
def jump_along_row(grid: BitGrid, row: int, column: int, direction: int, goal_row: int, goal_column: int) -> int:
    """Return the column of the jump point in this row, towards higher (1) or lower columns (-1); -1 if none."""
    goal = goal_column + MARGIN if goal_row == row else 0
    if direction > 0:
        place = scan_up(grid.rows, row + 1, column + MARGIN, goal)
    else:
        place = scan_down(grid.rows, row + 1, column + MARGIN, goal)
    return place - MARGIN if place else -1


@njit(cache=True)
def jump_along_column(grid: BitGrid, row: int, column: int, direction: int, goal_row: int, goal_column: int) -> int:
    """Return the row of the jump point in this column, towards higher (1) or lower rows (-1); -1 if none."""
    goal = goal_row + MARGIN if goal_column == column else 0
    if direction > 0:
        place = scan_up(grid.columns, column + 1, row + MARGIN, goal)
    else:
        place = scan_down(grid.columns, column + 1, row + MARGIN, goal)
    return place - MARGIN if place else -1


@njit(cache=True)
def jump_diagonally(
    grid: BitGrid,
    row: int,
    column: int,
    directions: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
    count: int,
) -> int:
    """Append the jump points along the rows and columns of a diagonal.

    The diagonal starts at a cell in the directions 1 or -1 of rows and of columns. ``found`` is the output: rows and
    columns of jump points, shape (n, 2), with ``count`` entries so far; return the new count.
    """
    row_direction, column_direction = directions
    while not (
        is_blocked(grid, row + row_direction, column)
        or is_blocked(grid, row, column + column_direction)
        or is_blocked(grid, row + row_direction, column + column_direction)
    ):
        row += row_direction
        column += column_direction
        if row == goal[0] and column == goal[1]:
            found[count, 0], found[count, 1] = row, column
            return count + 1
        place = jump_along_row(grid, row, column, column_direction, goal[0], goal[1])
        if place >= 0:
            found[count, 0], found[count, 1] = row, place
            count += 1
        place = jump_along_column(grid, row, column, row_direction, goal[0], goal[1])
        if place >= 0:
            found[count, 0], found[count, 1] = place, column
            count += 1
    return count


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
def successors_of_start(grid: BitGrid, row: int, column: int, goal: tuple[int, int], found: NDArray[np.int32]) -> int:
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
    grid: BitGrid, row: int, column: int, parent: tuple[int, int], goal: tuple[int, int], found: NDArray[np.int32]
) -> int:
    """Find the jump points that follow a jump point; arguments as for `jump_diagonally`, return their number.

    The path from the ``parent``, the previous jump point, ends with straight steps.
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
