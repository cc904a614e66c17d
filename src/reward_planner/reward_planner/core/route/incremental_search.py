"""Numba kernels of D* Lite (Koenig and Likhachev, AAAI 2002, figure 4), searched from the goal.

Every cell has the cost-to-goal g and the one-step lookahead value rhs; inconsistent cells (g != rhs) are in the open
list. Grids have a blocked border and cells are flat indices, so neighbours need no range checks.
A key is one integer: min(g, rhs) + h + k_m, then min(g, rhs) quantised to less than a cell as the tie-breaker. Only the
order of neighbours matters for that, and they are at least a cell apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.route.octile import DIAGONAL, STRAIGHT, octile_units
from reward_planner.core.route.open_list import drop_first, push

NO_WAY = 1 << 60

_TIE_BITS = 20
_TIE_STEP = 18  # 2^18 units are about half a cell
_TIE_MAX = (1 << _TIE_BITS) - 1
_LAST_KEY = (1 << 63) - 1


class SearchState(NamedTuple):
    """State of the search between replans; all arrays are flat over the grid with its border.

    Attributes:
        blocked: cells that the robot cannot enter.
        g: cost-to-goal g of each cell [1/STRAIGHT cells], `UNREACHED` if unknown; int64.
        rhs: one-step lookahead of g over the best neighbour [1/STRAIGHT cells]; int64.
        width: cells in a row, with the border.
        goal: index of the goal cell.
    """

    blocked: NDArray[np.bool_]
    lengths: NDArray[np.int64]
    promises: NDArray[np.int64]
    width: int
    goal: int


class OpenCells(NamedTuple):
    """The open list.

    Attributes:
        keys: heap of keys, some may be out of date; int64.
        cells: cell of each key; int32.
        size: number of entries.
    """

    keys: NDArray[np.int64]
    cells: NDArray[np.int32]
    size: int


@njit(cache=True)
def units_between(state: SearchState, cell: int, other: int) -> int:
    """Return the octile distance between two cells, the heuristic h [1/STRAIGHT cells]."""
    row, other_row = cell // state.width, other // state.width
    return octile_units(row, cell - row * state.width, other_row, other - other_row * state.width)


@njit(cache=True)
def key_of(state: SearchState, cell: int, start: int, moved: int) -> int:
    """Return the key of a cell; ``key_modifier`` is k_m, the motion of the start so far [1/STRAIGHT cells]."""
    length = min(state.lengths[cell], state.promises[cell])
    if length >= NO_WAY:
        return _LAST_KEY
    whole = length + units_between(state, cell, start) + moved
    return (whole << _TIE_BITS) + min(length >> _TIE_STEP, _TIE_MAX)


@njit(cache=True)
def step_of(state: SearchState, number: int) -> tuple[int, int]:
    """Return the index offset and the step length of neighbour 0 to 7, straight ones first."""
    width = state.width
    if number < 4:
        return (1, -1, width, -width)[number], STRAIGHT
    return (width + 1, width - 1, -width + 1, -width - 1)[number - 4], DIAGONAL


@njit(cache=True)
def is_open(state: SearchState, cell: int, offset: int) -> bool:
    """Return whether the robot can go from a free cell to a neighbour without cutting a blocked corner."""
    if state.blocked[cell + offset]:
        return False
    width = state.width
    if offset in (1, -1, width, -width):
        return True
    across = 1 if offset in (width + 1, -width + 1) else -1
    return not (state.blocked[cell + across] or state.blocked[cell + offset - across])


@njit(cache=True)
def best_promise(state: SearchState, cell: int) -> int:
    """Return rhs: the cost-to-goal over the best neighbour."""
    if cell == state.goal:
        return 0
    best = NO_WAY
    if not state.blocked[cell]:
        for number in range(8):
            offset, step = step_of(state, number)
            if state.lengths[cell + offset] + step < best and is_open(state, cell, offset):
                best = state.lengths[cell + offset] + step
    return best


@njit(cache=True)
def with_cell(state: SearchState, opened: OpenCells, cell: int, start: int, moved: int) -> OpenCells:
    """Insert a cell into the open list if it is inconsistent (UpdateVertex)."""
    if state.lengths[cell] == state.promises[cell]:
        return opened
    keys, cells, size = opened
    if size == len(keys):
        keys, cells, size = _with_room(state, opened)
    push(keys, cells, size, key_of(state, cell, start, moved), cell)
    return OpenCells(keys, cells, size + 1)


@njit(cache=True)
def _with_room(state: SearchState, opened: OpenCells) -> OpenCells:
    """Drop consistent cells from a full open list, and grow it if needed."""
    keys, cells = np.empty_like(opened.keys), np.empty_like(opened.cells)
    size = int(np.int64(0))
    for k in range(opened.size):
        cell = np.int64(opened.cells[k])
        if state.lengths[cell] != state.promises[cell]:
            push(keys, cells, size, opened.keys[k], cell)
            size += 1
    if 2 * size > len(keys):
        keys, cells = np.concatenate((keys, keys)), np.concatenate((cells, cells))
    return OpenCells(keys, cells, size)


@njit(cache=True)
def write_changes(
    state: SearchState, cells: NDArray[np.int64], blocked: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Set cells blocked or free, and return the indices of those that changed.

    Args:
        state: state of the search.
        cells: rows and columns without border, shape (n, 2).
        blocked: whether each cell is blocked, shape (n,).
    """
    changed = np.empty(len(cells), np.int64)
    count = 0
    for k in range(len(cells)):
        cell = (cells[k, 0] + 1) * state.width + cells[k, 1] + 1
        if state.blocked[cell] != blocked[k]:
            state.blocked[cell] = blocked[k]
            changed[count] = cell
            count += 1
    return changed[:count]


@njit(cache=True)
def mend(
    state: SearchState, opened: OpenCells, changed: NDArray[np.int64], start: int, moved: int
) -> tuple[OpenCells, NDArray[np.int64]]:
    """Repair the search after changes; return the open list and the cells of a shortest route, empty if there is none.

    Args:
        state: state of the search.
        open_list: cells to expand.
        changed: indices of the cells that became blocked or free since the last call.
        start: index of the robot's cell.
        key_modifier: k_m, the sum of the robot's motions from start to start [1/STRAIGHT cells].
    """
    opened = take_changes(state, opened, changed, start, moved)
    opened = search_again(state, opened, start, moved)
    if state.promises[start] >= NO_WAY:
        return opened, np.empty((0, 2), np.int64)
    return opened, way_to_goal(state, start)


@njit(cache=True)
def take_changes(
    state: SearchState, opened: OpenCells, changed: NDArray[np.int64], start: int, moved: int
) -> OpenCells:
    """Update rhs around cells that became blocked or free; return the open list."""
    width = state.width
    for cell in changed:
        for row_begin in (cell - width, cell, cell + width):
            for near in range(row_begin - 1, row_begin + 2):
                # The border is blocked and never changes.
                if width <= near < len(state.blocked) - width and 0 < near % width < width - 1:
                    state.promises[near] = best_promise(state, near)
                    opened = with_cell(state, opened, near, start, moved)
    return opened


@njit(cache=True)
def search_again(state: SearchState, opened: OpenCells, start: int, moved: int) -> OpenCells:
    """Expand cells until the start is consistent (ComputeShortestPath); return the open list."""
    while opened.size and (
        opened.keys[0] < key_of(state, start, start, moved) or state.promises[start] > state.lengths[start]
    ):
        # One integer type for all callers, since numba compiles a kernel for each.
        key, cell = opened.keys[0], np.int64(opened.cells[0])
        drop_first(opened.keys, opened.cells, opened.size)
        opened = OpenCells(opened.keys, opened.cells, opened.size - 1)
        length, promise = state.lengths[cell], state.promises[cell]
        key_now = key_of(state, cell, start, moved)
        if length == promise or key > key_now:
            continue  # outdated entry
        if key < key_now:
            opened = with_cell(state, opened, cell, start, moved)
        elif length > promise:
            opened = _shorten(state, opened, cell, start, moved)
        else:
            opened = _forget(state, opened, cell, start, moved)
    return opened


@njit(cache=True)
def _shorten(state: SearchState, opened: OpenCells, cell: int, start: int, moved: int) -> OpenCells:
    """Set g of an overconsistent cell to rhs, and update its neighbours."""
    state.lengths[cell] = state.promises[cell]
    if state.blocked[cell]:
        return opened
    for number in range(8):
        offset, step = step_of(state, number)
        near, length = cell + offset, state.lengths[cell] + step
        if length < state.promises[near] and is_open(state, cell, offset):
            state.promises[near] = length
            opened = with_cell(state, opened, near, start, moved)
    return opened


@njit(cache=True)
def _forget(state: SearchState, opened: OpenCells, cell: int, start: int, moved: int) -> OpenCells:
    """Raise g of an underconsistent cell, and update the neighbours that depended on it."""
    before = state.lengths[cell]
    state.lengths[cell] = NO_WAY
    opened = with_cell(state, opened, cell, start, moved)
    for number in range(8):
        offset, step = step_of(state, number)
        near = cell + offset
        if state.promises[near] == before + step and near != state.goal:
            state.promises[near] = best_promise(state, near)
            opened = with_cell(state, opened, near, start, moved)
    return opened


@njit(cache=True)
def way_to_goal(state: SearchState, start: int) -> NDArray[np.int64]:
    """Return the cells from start to goal, straight steps first, rows and columns without border, shape (n, 2)."""
    numbers = np.empty(1024, np.int64)
    numbers[0], count = start, 1
    while numbers[count - 1] != state.goal:
        cell = numbers[count - 1]
        best, best_length = cell, NO_WAY
        for number in range(8):
            offset, step = step_of(state, number)
            if state.lengths[cell + offset] + step < best_length and is_open(state, cell, offset):
                best, best_length = cell + offset, state.lengths[cell + offset] + step
                if best_length == state.promises[cell]:
                    break
        if count == len(numbers):
            numbers = np.concatenate((numbers, numbers))
        numbers[count] = best
        count += 1
    return _rows_and_columns(numbers[:count], state.width)


@njit(cache=True)
def _rows_and_columns(numbers: NDArray[np.int64], width: int) -> NDArray[np.int64]:
    """Convert cell indices to rows and columns without border, shape (n, 2)."""
    cells = np.empty((len(numbers), 2), np.int64)
    for k in range(len(numbers)):
        row = numbers[k] // width
        cells[k, 0], cells[k, 1] = row - 1, numbers[k] - row * width - 1
    return cells
