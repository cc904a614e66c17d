"""Shortest route on a grid: A* with jump point search."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.route.jump_points import BitGrid, pack_grid, successors, successors_of_start
from reward_planner.core.route.route import STRAIGHT, NoRoute, Route, check_endpoints, octile_distance


@njit(cache=True)
def push(keys: NDArray[np.int64], cells: NDArray[np.int32], size: int, key: int, cell: int) -> None:
    """Add a cell to a heap of ``size`` entries; the arrays must have room for it."""
    child = size
    while child:
        parent = (child - 1) >> 2
        if keys[parent] <= key:
            break
        keys[child], cells[child] = keys[parent], cells[parent]
        child = parent
    keys[child], cells[child] = key, cell


@njit(cache=True)
def pop_first(keys: NDArray[np.int64], cells: NDArray[np.int32], size: int) -> None:
    """Remove the entry with the least key, at index 0, from a heap of ``size`` entries."""
    last = size - 1
    key, cell = keys[last], cells[last]
    hole = 0
    while True:
        first = 4 * hole + 1
        if first >= last:
            break
        least = first
        for child in range(first + 1, min(first + 4, last)):
            if keys[child] < keys[least]:
                least = child
        if keys[least] >= key:
            break
        keys[hole], cells[hole] = keys[least], cells[least]
        hole = least
    keys[hole], cells[hole] = key, cell


_TIE_BITS = 20  # low bits of a key: distance to the goal [cells]; high bits: estimated length of the route


def shortest_route(blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]) -> Route | NoRoute:
    """Return a shortest route of straight and diagonal steps on a grid, shape (rows, columns); it cuts no corner.

    A diagonal step needs both adjacent cells free. Of equally long routes, the one with straight steps first is
    returned; in unknown terrain it meets fewer obstacles.
    """
    failure = check_endpoints(blocked, start, goal)
    if failure is not None:
        return failure
    rows, columns = blocked.shape
    shift = columns.bit_length()
    # np.zeros allocates pages only when they are touched; most cells never are.
    lengths = np.zeros(rows << shift, dtype=np.int64)
    parents = np.zeros(rows << shift, dtype=np.int32)
    # Search from the goal: it makes diagonal steps first, so the robot makes straight steps first.
    if not _search(pack_grid(blocked), shift, goal, start, lengths, parents):
        return NoRoute.UNREACHABLE
    cells = _expand_path(parents, shift, goal, start)[::-1]
    return Route(cells)


@njit(cache=True)
def _search(
    grid: BitGrid,
    shift: int,
    start: tuple[int, int],
    goal: tuple[int, int],
    lengths: NDArray[np.int64],
    parents: NDArray[np.int32],
) -> bool:
    """Find the jump points of a shortest route; return whether there is one.

    Cell (r, c) has the index (r << shift) + c. Outputs are the path length to each jump point plus one, 0 for none
    [1/STRAIGHT cells], and the index of the previous jump point.
    """
    keys, cells = np.empty(1024, np.int64), np.empty(1024, np.int32)
    found = np.empty((4 * (len(grid.rows) + len(grid.columns)), 2), np.int32)
    first, last = (start[0] << shift) + start[1], (goal[0] << shift) + goal[1]
    keys[0], cells[0], size, lengths[first] = 0, first, 1, 1
    while size and cells[0] != last:
        key, cell = keys[0], cells[0]
        pop_first(keys, cells, size)
        size -= 1
        row, column = cell >> shift, cell & ((1 << shift) - 1)
        if cell == first:
            count = successors_of_start(grid, row, column, goal, found)
        elif (key >> _TIE_BITS) > lengths[cell] + octile_distance(row, column, goal[0], goal[1]):
            continue  # outdated entry: a shorter path was found since
        else:
            parent = (parents[cell] >> shift, parents[cell] & ((1 << shift) - 1))
            count = successors(grid, row, column, parent, goal, found)
        while size + count > len(keys):
            keys, cells = np.concatenate((keys, keys)), np.concatenate((cells, cells))
        for k in range(count):
            next_row, next_column = found[k]
            length = lengths[cell] + octile_distance(row, column, next_row, next_column)
            next_cell = (next_row << shift) + next_column
            if lengths[next_cell] == 0 or length < lengths[next_cell]:
                lengths[next_cell], parents[next_cell] = length, cell
                h = octile_distance(next_row, next_column, goal[0], goal[1])
                push(keys, cells, size, ((length + h) << _TIE_BITS) + h // STRAIGHT, next_cell)
                size += 1
    return size > 0


@njit(cache=True)
def _expand_path(
    parents: NDArray[np.int32], shift: int, start: tuple[int, int], goal: tuple[int, int]
) -> NDArray[np.int64]:
    """Return all cells from start to goal, shape (n, 2); between jump points diagonal steps come first."""
    row, column = goal
    count = 1
    while row != start[0] or column != start[1]:
        before = parents[(row << shift) + column]
        to_row, to_column = before >> shift, before & ((1 << shift) - 1)
        count += max(abs(to_row - row), abs(to_column - column))
        row, column = to_row, to_column
    cells = np.empty((count, 2), np.int64)
    row, column = goal
    cells[count - 1, 0], cells[count - 1, 1] = row, column
    while count > 1:
        before = parents[(row << shift) + column]
        to_row, to_column = before >> shift, before & ((1 << shift) - 1)
        while row != to_row or column != to_column:
            rows, columns = to_row - row, to_column - column
            if abs(rows) >= abs(columns):
                row += np.sign(rows)
            if abs(columns) >= abs(rows):
                column += np.sign(columns)
            count -= 1
            cells[count - 1, 0], cells[count - 1, 1] = row, column
    return cells
