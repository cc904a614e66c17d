"""A world of free and occupied cells that a robot sees only near by and in line of sight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray


@dataclass(frozen=True)
class GridWorld:
    """The truth.

    Attributes:
        occupied: shape (rows, columns).
    """

    occupied: NDArray[np.bool_]

    def sense(self, cell: tuple[int, int], reach: float) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return what a robot sees from the centre of its cell.

        Args:
            cell: row and column of the robot.
            reach: how far it sees [cells].

        Returns:
            shape (n, 2), the cells that it sees, row and column, and shape (n,), whether they are occupied. A cell is
            seen when no other occupied cell is on the line to its centre.
        """
        cells = visible_cells(self.occupied, cell[0], cell[1], reach)
        return cells, self.occupied[cells[:, 0], cells[:, 1]]


@njit(cache=True)
def visible_cells(occupied: NDArray[np.bool_], row: int, column: int, reach: float) -> NDArray[np.int64]:
    """Return the cells in reach to whose centre no occupied cell hides the line, shape (n, 2)."""
    rows, columns = occupied.shape
    span = int(reach)
    seen = np.empty(((2 * span + 1) ** 2, 2), np.int64)
    count = 0
    for to_row in range(max(0, row - span), min(rows, row + span + 1)):
        for to_column in range(max(0, column - span), min(columns, column + span + 1)):
            if (to_row - row) ** 2 + (to_column - column) ** 2 > reach * reach:
                continue
            if _line_is_free(occupied, row, column, to_row, to_column):
                seen[count, 0], seen[count, 1] = to_row, to_column
                count += 1
    return seen[:count]


@njit(cache=True)
def _line_is_free(occupied: NDArray[np.bool_], row: int, column: int, to_row: int, to_column: int) -> bool:
    """Return whether the cells between two cells are free, one for each step along the longer axis."""
    rows, columns = to_row - row, to_column - column
    steps = max(abs(rows), abs(columns))
    for k in range(1, steps):
        if occupied[row + round(k * rows / steps), column + round(k * columns / steps)]:
            return False
    return True
