"""A grid world observed within range and line of sight, and its shortest paths: Dijkstra over the graph of all steps.

Steps go to the eight neighbours, straight ones are 1 and diagonal ones sqrt(2) cells long, and no corner is cut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

_RAYS = 720  # all around: ten cells away they are a tenth of a cell apart


@dataclass(frozen=True)
class GridWorld:
    """The truth.

    Attributes:
        occupied: shape (rows, columns).
    """

    occupied: NDArray[np.bool_]

    def observe(self, cell: tuple[int, int], max_range: float) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return the cells visible from the centre of the robot's cell, shape (n, 2), row and column, within a range.

        They are those that a ray enters before it is stopped and those that stop one; and whether they are occupied.
        """
        cells = visible_cells(self.occupied, cell[0], cell[1], max_range)
        return cells, self.occupied[cells[:, 0], cells[:, 1]]


@njit(cache=True)
def visible_cells(occupied: NDArray[np.bool_], row: int, column: int, max_range: float) -> NDArray[np.int64]:
    """Return the cells that rays from the centre of a cell enter, up to the first occupied one, shape (n, 2)."""
    span = int(max_range) + 1
    seen = np.zeros((2 * span + 1, 2 * span + 1), np.bool_)
    seen[span, span] = True
    for k in range(_RAYS):
        _trace_ray(occupied, row, column, (k + 0.5) * 2.0 * math.pi / _RAYS, max_range, seen)
    offsets = np.argwhere(seen)
    for k in range(len(offsets)):
        offsets[k, 0] += row - span
        offsets[k, 1] += column - span
    return offsets


@njit(cache=True)
def _trace_ray(
    occupied: NDArray[np.bool_], row: int, column: int, angle: float, max_range: float, seen: NDArray[np.bool_]
) -> None:
    """Follow a ray from cell to cell (Amanatides and Woo 1987); it runs along no axis."""
    up, right = math.sin(angle), math.cos(angle)
    row_step, column_step = (1 if up > 0.0 else -1), (1 if right > 0.0 else -1)
    next_row, next_column = 0.5 / abs(up), 0.5 / abs(right)
    to_row, to_column = row, column
    while True:
        if next_row < next_column:
            travelled = next_row
            to_row += row_step
            next_row += 1.0 / abs(up)
        else:
            travelled = next_column
            to_column += column_step
            next_column += 1.0 / abs(right)
        inside = 0 <= to_row < occupied.shape[0] and 0 <= to_column < occupied.shape[1]
        if travelled > max_range or not inside:
            return
        seen[to_row - row + len(seen) // 2, to_column - column + len(seen) // 2] = True
        if occupied[to_row, to_column]:
            return


def step_graph(blocked: NDArray[np.bool_]) -> csr_array[np.float64, tuple[int, int]]:
    """Return the steps between free cells; the cell (r, c) has the number r * columns + c."""
    rows, columns = blocked.shape
    numbers = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    free = np.pad(~blocked, 1)
    steps = []
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            if down == right == 0:
                continue
            adjacent_cells = [(0, 0), (down, right), (down, 0), (0, right)]
            is_allowed = np.logical_and.reduce(
                [free[1 + a : 1 + a + rows, 1 + b : 1 + b + columns] for a, b in adjacent_cells]
            )
            row, column = np.nonzero(is_allowed)
            lengths = np.full(len(row), np.hypot(down, right))
            steps.append((numbers[row, column], numbers[row + down, column + right], lengths))
    begins, ends, lengths = (np.concatenate(parts) for parts in zip(*steps, strict=True))
    return coo_array((lengths, (begins, ends)), shape=(rows * columns, rows * columns)).tocsr()


def distances_from(
    blocked: NDArray[np.bool_], start: tuple[int, int], graph: csr_array[np.float64, tuple[int, int]] | None = None
) -> NDArray[np.float64]:
    """Return the length of the shortest route from a cell to every cell [cells], infinite where there is none.

    The graph may be a precomputed ``step_graph``, for many starts.
    """
    number = start[0] * blocked.shape[1] + start[1]
    return np.asarray(dijkstra(step_graph(blocked) if graph is None else graph, indices=number)).reshape(blocked.shape)


def is_traversable(blocked: NDArray[np.bool_], cells: NDArray[np.int64]) -> bool:
    """Return whether every step between cells, shape (n, 2), is to a free neighbour, without cutting corners."""
    (rows, columns), (downs, rights) = cells.T, np.diff(cells, axis=0).T
    near = bool((np.maximum(np.abs(downs), np.abs(rights)) == 1).all())
    hits = blocked[rows, columns].any()
    cuts = blocked[rows[:-1] + downs, columns[:-1]] | blocked[rows[:-1], columns[:-1] + rights]
    return near and not hits and not cuts.any()
