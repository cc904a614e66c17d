"""Numba kernels of D* Lite (Koenig and Likhachev, AAAI 2002, figure 4), searched from the goal.

An edge costs its length times one plus the mean traversal cost of its two cells, which is 0 for shortest routes.
Every cell has the cost-to-goal g and the one-step lookahead value rhs; inconsistent cells (g != rhs) are in the open
list. Grids have a blocked border and cells are flat indices, so neighbours need no range checks.
A key is one integer: min(g, rhs) + h + k_m, then min(g, rhs) quantised to less than a cell as the tie-breaker. Only the
order of neighbours matters for that, and they are at least a cell apart.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.route.route import COST_MAX, DIAGONAL, STRAIGHT, octile_distance
from reward_planner.core.route.shortest_route import pop_first, push

UNREACHED = 1 << 60

_TIE_BITS = 20
_TIE_STEP = 18  # 2^18 units are about half a cell
_TIE_MAX = (1 << _TIE_BITS) - 1
_LAST_KEY = (1 << 63) - 1
_TOTAL_MAX = (1 << (63 - _TIE_BITS)) - 1  # costs beyond do not fit into a key: 18 million cells without obstacles

WEIGHT_BITS = 20


class SearchState(NamedTuple):
    """State of the search between replans; all arrays are flat over the grid with its border.

    Attributes:
        costs: cost of each cell, those above `COST_MAX` are blocked; uint8.
        weight: traversal cost of a cell of cost 1, halved [2^-WEIGHT_BITS].
        g: cost-to-goal g of each cell [1/STRAIGHT cells], `UNREACHED` if unknown; int64.
        rhs: one-step lookahead of g over the best neighbour [1/STRAIGHT cells]; int64.
        width: cells in a row, with the border.
        goal: index of the goal cell.
    """

    costs: NDArray[np.uint8]
    weight: int
    g: NDArray[np.int64]
    rhs: NDArray[np.int64]
    width: int
    goal: int


class OpenList(NamedTuple):
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
def cell_distance(state: SearchState, cell: int, other: int) -> int:
    """Return the octile distance between two cells, the heuristic h [1/STRAIGHT cells]."""
    row, other_row = cell // state.width, other // state.width
    return octile_distance(row, cell - row * state.width, other_row, other - other_row * state.width)


@njit(cache=True)
def key_of(state: SearchState, cell: int, start: int, key_modifier: int) -> int:
    """Return the key of a cell; ``key_modifier`` is k_m, the motion of the start so far [1/STRAIGHT cells]."""
    cell_g = min(state.g[cell], state.rhs[cell])
    if cell_g >= UNREACHED:
        return _LAST_KEY
    total = min(cell_g + cell_distance(state, cell, start) + key_modifier, _TOTAL_MAX)
    return (total << _TIE_BITS) + min(cell_g >> _TIE_STEP, _TIE_MAX)


@njit(cache=True)
def step_of(state: SearchState, number: int) -> tuple[int, int]:
    """Return the index offset and the step length of neighbour 0 to 7, straight ones first."""
    width = state.width
    if number < 4:
        return (1, -1, width, -width)[number], STRAIGHT
    return (width + 1, width - 1, -width + 1, -width - 1)[number - 4], DIAGONAL


@njit(cache=True)
def edge_cost(state: SearchState, cell: int, other: int, step: int) -> int:
    """Return the cost c of the edge between two neighbours, ``step`` is its length; the same in both directions."""
    if state.weight == 0:
        return step
    both = int(np.int64(state.costs[cell]) + np.int64(state.costs[other]))  # uint8 would become floats in numba
    return step + ((step * state.weight * both) >> WEIGHT_BITS)


@njit(cache=True)
def is_traversable(state: SearchState, cell: int, offset: int) -> bool:
    """Return whether the robot can go from a free cell to a neighbour without cutting a blocked corner."""
    if state.costs[cell + offset] > COST_MAX:
        return False
    width = state.width
    if offset in (1, -1, width, -width):
        return True
    across = 1 if offset in (width + 1, -width + 1) else -1
    return state.costs[cell + across] <= COST_MAX and state.costs[cell + offset - across] <= COST_MAX


@njit(cache=True)
def best_rhs(state: SearchState, cell: int) -> int:
    """Return rhs: the cost-to-goal over the best neighbour."""
    if cell == state.goal:
        return 0
    best = UNREACHED
    if state.costs[cell] <= COST_MAX:
        for number in range(8):
            offset, step = step_of(state, number)
            if state.g[cell + offset] + step < best and is_traversable(state, cell, offset):
                best = min(best, state.g[cell + offset] + edge_cost(state, cell, cell + offset, step))
    return best


@njit(cache=True)
def insert_if_inconsistent(
    state: SearchState, open_list: OpenList, cell: int, start: int, key_modifier: int
) -> OpenList:
    """Insert a cell into the open list if it is inconsistent (UpdateVertex)."""
    if state.g[cell] == state.rhs[cell]:
        return open_list
    keys, cells, size = open_list
    if size == len(keys):
        keys, cells, size = _compact_open_list(state, open_list)
    push(keys, cells, size, key_of(state, cell, start, key_modifier), cell)
    return OpenList(keys, cells, size + 1)


@njit(cache=True)
def _compact_open_list(state: SearchState, open_list: OpenList) -> OpenList:
    """Drop consistent cells from a full open list, and grow it if needed."""
    keys, cells = np.empty_like(open_list.keys), np.empty_like(open_list.cells)
    size = int(np.int64(0))
    for k in range(open_list.size):
        cell = np.int64(open_list.cells[k])
        if state.g[cell] != state.rhs[cell]:
            push(keys, cells, size, open_list.keys[k], cell)
            size += 1
    if 2 * size > len(keys):
        keys, cells = np.concatenate((keys, keys)), np.concatenate((cells, cells))
    return OpenList(keys, cells, size)


@njit(cache=True, nogil=True)
def apply_changes(state: SearchState, cells: NDArray[np.int64], costs: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Set the costs of cells (without border, shape (n, 2)); return the indices of those that changed."""
    changed = np.empty(len(cells), np.int64)
    count = 0
    for k in range(len(cells)):
        cell = (cells[k, 0] + 1) * state.width + cells[k, 1] + 1
        if state.costs[cell] != costs[k]:
            state.costs[cell] = costs[k]
            changed[count] = cell
            count += 1
    return changed[:count]


@njit(cache=True, nogil=True)
def replan(
    state: SearchState, open_list: OpenList, changed: NDArray[np.int64], start: int, key_modifier: int
) -> tuple[OpenList, NDArray[np.int64]]:
    """Repair the search after changes; return the open list and the cells of a least-cost route, empty if none.

    ``changed`` are the cells whose costs changed since the last call, ``start`` is the robot's cell, and
    ``key_modifier`` k_m, the sum of its motions so far [1/STRAIGHT cells].
    """
    # UpdateVertex of all cells whose edges changed.
    open_list = update_changed_cells(state, open_list, changed, start, key_modifier)
    # ComputeShortestPath: expand cells until the robot's one is consistent.
    open_list = compute_shortest_path(state, open_list, start, key_modifier)
    # There is no path if rhs of the robot's cell is infinite; else its cells follow the least cost-to-goal.
    if state.rhs[start] >= UNREACHED:
        return open_list, np.empty((0, 2), np.int64)
    return open_list, extract_path(state, start)


@njit(cache=True)
def update_changed_cells(
    state: SearchState, open_list: OpenList, changed: NDArray[np.int64], start: int, key_modifier: int
) -> OpenList:
    """Update rhs around cells whose costs changed (UpdateVertex); return the open list."""
    width = state.width
    for cell in changed:
        for row_begin in (cell - width, cell, cell + width):
            for neighbour in range(row_begin - 1, row_begin + 2):
                # The border is blocked and never changes.
                if width <= neighbour < len(state.costs) - width and 0 < neighbour % width < width - 1:
                    state.rhs[neighbour] = best_rhs(state, neighbour)
                    open_list = insert_if_inconsistent(state, open_list, neighbour, start, key_modifier)
    return open_list


@njit(cache=True)
def compute_shortest_path(state: SearchState, open_list: OpenList, start: int, key_modifier: int) -> OpenList:
    """Expand cells until the start is consistent (ComputeShortestPath); return the open list."""
    while open_list.size and (
        open_list.keys[0] < key_of(state, start, start, key_modifier) or state.rhs[start] > state.g[start]
    ):
        # One integer type for all callers, since numba compiles a kernel for each.
        key, cell = open_list.keys[0], np.int64(open_list.cells[0])
        pop_first(open_list.keys, open_list.cells, open_list.size)
        open_list = OpenList(open_list.keys, open_list.cells, open_list.size - 1)
        cell_g, cell_rhs = state.g[cell], state.rhs[cell]
        key_now = key_of(state, cell, start, key_modifier)
        if cell_g == cell_rhs or key > key_now:
            continue  # outdated entry
        if key < key_now:
            open_list = insert_if_inconsistent(state, open_list, cell, start, key_modifier)
        elif cell_g > cell_rhs:
            open_list = _process_overconsistent(state, open_list, cell, start, key_modifier)
        else:
            open_list = _process_underconsistent(state, open_list, cell, start, key_modifier)
    return open_list


@njit(cache=True)
def _process_overconsistent(
    state: SearchState, open_list: OpenList, cell: int, start: int, key_modifier: int
) -> OpenList:
    """Set g of an overconsistent cell to rhs, and update its neighbours."""
    state.g[cell] = state.rhs[cell]
    if state.costs[cell] > COST_MAX:
        return open_list
    for number in range(8):
        offset, step = step_of(state, number)
        neighbour = cell + offset
        cell_g = state.g[cell] + edge_cost(state, cell, neighbour, step)
        if cell_g < state.rhs[neighbour] and is_traversable(state, cell, offset):
            state.rhs[neighbour] = cell_g
            open_list = insert_if_inconsistent(state, open_list, neighbour, start, key_modifier)
    return open_list


@njit(cache=True)
def _process_underconsistent(
    state: SearchState, open_list: OpenList, cell: int, start: int, key_modifier: int
) -> OpenList:
    """Raise g of an underconsistent cell, and update the neighbours that depended on it."""
    before = state.g[cell]
    state.g[cell] = UNREACHED
    open_list = insert_if_inconsistent(state, open_list, cell, start, key_modifier)
    for number in range(8):
        offset, step = step_of(state, number)
        neighbour = cell + offset
        total = before + edge_cost(state, cell, neighbour, step)
        if state.rhs[neighbour] == total and neighbour != state.goal:
            state.rhs[neighbour] = best_rhs(state, neighbour)
            open_list = insert_if_inconsistent(state, open_list, neighbour, start, key_modifier)
    return open_list


@njit(cache=True)
def extract_path(state: SearchState, start: int) -> NDArray[np.int64]:
    """Return the cells from start to goal, straight steps first, rows and columns without border, shape (n, 2)."""
    numbers = np.empty(1024, np.int64)
    numbers[0], count = start, 1
    while numbers[count - 1] != state.goal:
        cell = numbers[count - 1]
        best, best_length = cell, UNREACHED
        for number in range(8):
            offset, step = step_of(state, number)
            total = state.g[cell + offset] + edge_cost(state, cell, cell + offset, step)
            if total < best_length and is_traversable(state, cell, offset):
                best, best_length = cell + offset, total
                if best_length == state.rhs[cell]:
                    break
        if count == len(numbers):
            numbers = np.concatenate((numbers, numbers))
        numbers[count] = best
        count += 1
    cells = np.empty((count, 2), np.int64)
    for k in range(count):
        row = numbers[k] // state.width
        cells[k, 0], cells[k, 1] = row - 1, numbers[k] - row * state.width - 1
    return cells
