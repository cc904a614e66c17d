"""Map dots sorted into square cells, so that the dot nearest to a place is found in constant time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

# A bounding box that is mostly empty floor must not cost more memory than this for every dot.
_CELLS_PER_DOT = 16


class DotGrid(NamedTuple):
    """Dots in row-major order of their cells; the arrays may be memory-mapped.

    Attributes:
        points: shape (N, 2) float32, dots in the map frame [m], those of one cell side by side.
        starts: shape (rows * columns + 1,) int64, where each cell's dots begin.
        x0: lower edge of the first column [m].
        y0: lower edge of the first row [m].
        cell: side of a cell [m].
        columns: number of cells along x.
        rows: number of cells along y.
    """

    points: NDArray[np.float32]
    starts: NDArray[np.int64]
    x0: float
    y0: float
    cell: float
    columns: int
    rows: int


def build_dot_grid(points: NDArray[np.float64]) -> tuple[DotGrid, NDArray[np.int64]]:
    """Sort dots into cells that hold about one dot each.

    Args:
        points: shape (N, 2), dots in the map frame [m], N >= 1.

    Returns:
        the grid, and the order, shape (N,), such that ``points[order]`` are the grid's points.
    """
    lower = points.min(axis=0)
    size = np.maximum(points.max(axis=0) - lower, 1e-3)
    cell = max(typical_spacing(points), math.sqrt(size[0] * size[1] / (_CELLS_PER_DOT * len(points))))
    columns, rows = (int(n) + 1 for n in size // cell)
    column, row = ((points - lower) / cell).astype(np.int64).T
    flat = row * columns + column
    order = np.argsort(flat, kind='stable')
    starts = np.zeros(rows * columns + 1, dtype=np.int64)
    np.cumsum(np.bincount(flat, minlength=rows * columns), out=starts[1:])
    grid_points = points[order].astype(np.float32)
    for array in (grid_points, starts):
        array.flags.writeable = False
    return DotGrid(grid_points, starts, float(lower[0]), float(lower[1]), cell, columns, rows), order


def typical_spacing(points: NDArray[np.float64]) -> float:
    """Return the side of the square that holds one dot on average where there are dots [m].

    Only the part of the bounding box that holds dots counts, so that a map of several rooms is as dense as
    its rooms.

    Args:
        points: shape (N, 2), dots [m].
    """
    lower = points.min(axis=0)
    size = np.maximum(points.max(axis=0) - lower, 1e-3)
    coarse = max(math.sqrt(size[0] * size[1] / max(len(points) / 8.0, 1.0)), 1e-4)
    for _ in range(3):
        shape = (size // coarse).astype(np.int64) + 1
        occupied = len(np.unique(((points - lower) // coarse) @ np.array([1, shape[0]])))
        spacing = math.sqrt(occupied * coarse * coarse / len(points))
        coarse = spacing * math.sqrt(8.0)
    return spacing


def pair_density(grid: DotGrid) -> float:
    """Return how many other dots are found on a square metre next to a dot [1/m^2].

    On an evenly random floor this is the density; where dots crowd together it is higher, and so is chance.
    """
    side = 4
    rows, columns = grid.rows // side + 1, grid.columns // side + 1
    counts = np.zeros((rows * side, columns * side))
    counts[: grid.rows, : grid.columns] = np.diff(grid.starts).reshape(grid.rows, grid.columns)
    blocks = counts.reshape(rows, side, columns, side).sum(axis=(1, 3))
    pairs = float(np.sum(blocks * (blocks - 1.0)) / np.sum(blocks))
    return max(pairs / (side * grid.cell) ** 2, 1.0 / grid.cell**2)


@njit(cache=True)
def nearest_dot(grid: DotGrid, x: float, y: float, reach: float) -> tuple[int, float]:
    """Return the index of the dot nearest to (x, y) within ``reach`` [m] and its squared distance, or -1."""
    first_column = max(int((x - reach - grid.x0) / grid.cell), 0)
    last_column = min(int((x + reach - grid.x0) / grid.cell), grid.columns - 1)
    first_row = max(int((y - reach - grid.y0) / grid.cell), 0)
    last_row = min(int((y + reach - grid.y0) / grid.cell), grid.rows - 1)
    best, best_squared = -1, reach * reach
    if last_column < first_column:
        return best, best_squared
    for row in range(first_row, last_row + 1):
        start = grid.starts[row * grid.columns + first_column]
        end = grid.starts[row * grid.columns + last_column + 1]
        for i in range(start, end):
            dx = grid.points[i, 0] - x
            dy = grid.points[i, 1] - y
            squared = dx * dx + dy * dy
            if squared < best_squared:
                best, best_squared = i, squared
    return best, best_squared


@njit(cache=True)
def dots_within(grid: DotGrid, x: float, y: float, reach: float, found: NDArray[np.int64]) -> int:
    """Write the indices of the dots within ``reach`` [m] of (x, y) to ``found`` and return their number.

    When there are more than ``found`` holds, the rest is left out.
    """
    first_column = max(int((x - reach - grid.x0) / grid.cell), 0)
    last_column = min(int((x + reach - grid.x0) / grid.cell), grid.columns - 1)
    first_row = max(int((y - reach - grid.y0) / grid.cell), 0)
    last_row = min(int((y + reach - grid.y0) / grid.cell), grid.rows - 1)
    count = 0
    if last_column < first_column:
        return count
    for row in range(first_row, last_row + 1):
        start = grid.starts[row * grid.columns + first_column]
        end = grid.starts[row * grid.columns + last_column + 1]
        for i in range(start, end):
            dx = grid.points[i, 0] - x
            dy = grid.points[i, 1] - y
            if dx * dx + dy * dy <= reach * reach and count < len(found):
                found[count] = i
                count += 1
    return count
