"""Spatial hash of the map dots: sorted into square cells, the dot nearest to a position is found in constant time."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Float32s, Floats, Ints

# Maximum number of cells per dot: limits the memory of a bounding box that is mostly empty floor.
_CELLS_PER_DOT = 16

BLOCK_ROWS = 4  # side of a block in which pairs of dots are counted [cells]


class DotGrid(NamedTuple):
    """Dots in row-major order of their cells; the arrays may be memory-mapped.

    Attributes:
        points: shape (N, 2) float32, dots in the map frame [m], those of one cell contiguous.
        starts: shape (rows * columns + 1,) uint32, first dot of each cell.
        x0: lower edge of the first column [m].
        y0: lower edge of the first row [m].
        cell: side of a cell [m].
        columns: number of cells along x.
        rows: number of cells along y.
    """

    points: Float32s
    starts: NDArray[np.uint32]
    x0: float
    y0: float
    cell: float
    columns: int
    rows: int


class GridLayout(NamedTuple):
    """How the floor is divided into cells.

    Attributes:
        x0: lower edge of the first column [m].
        y0: lower edge of the first row [m].
        cell: side of a cell [m].
        columns: number of cells along x.
        rows: number of cells along y.
    """

    x0: float
    y0: float
    cell: float
    columns: int
    rows: int


def grid_layout(lower: Floats, upper: Floats, dots: int, spacing: float) -> GridLayout:
    """Return the layout of cells that hold about one dot each.

    ``lower`` and ``upper`` are the corners of the dots' bounding box [m], ``spacing`` is their `typical_spacing` [m].
    """
    size = np.maximum(upper - lower, 1e-3)
    cell = max(spacing, math.sqrt(size[0] * size[1] / (_CELLS_PER_DOT * dots)))
    columns, rows = (int(n) + 1 for n in size // cell)
    return GridLayout(float(lower[0]), float(lower[1]), cell, columns, rows)


def rows_and_columns(layout: GridLayout, points: Floats) -> tuple[Ints, Ints]:
    """Return rows and columns, shape (N,) each, of the cells of points, shape (N, 2) [m]."""
    column, row = ((points - (layout.x0, layout.y0)) / layout.cell).astype(np.int64).T
    return row, column


def build_dot_grid(points: Floats) -> tuple[DotGrid, Ints]:
    """Sort dots, shape (N, 2), N >= 1 [m], into cells that hold about one dot each.

    Returns:
        the grid, and its order of the dots, shape (N,): ``points[order]`` are the grid's points.
    """
    rounded = points.astype(np.float32)
    points = rounded.astype(np.float64)
    layout = grid_layout(points.min(axis=0), points.max(axis=0), len(points), typical_spacing(points))
    row, column = rows_and_columns(layout, points)
    order, starts = sort_into_cells(row * layout.columns + column, layout.rows * layout.columns)
    grid_points = rounded[order]
    for array in (grid_points, starts):
        array.flags.writeable = False
    return DotGrid(grid_points, starts, *layout), order


def sort_into_cells(cells: Ints, number: int) -> tuple[Ints, NDArray[np.uint32]]:
    """Return the order of dots by cell, shape (N,), and the first dot of each cell, shape (number + 1,)."""
    order = np.argsort(cells, kind='stable')
    starts = np.zeros(number + 1, dtype=np.uint32)
    starts[1:] = np.cumsum(np.bincount(cells, minlength=number))
    return order, starts


def typical_spacing(points: Floats) -> float:
    """Return the mean spacing of dots, shape (N, 2): the side of the square that holds one dot on average [m].

    Only the occupied part of the bounding box counts, so that a map of several rooms is as dense as its rooms.
    """
    lower, upper = points.min(axis=0), points.max(axis=0)
    return spacing_from_counts(
        lower, upper, len(points), lambda side: len(np.unique(square_indices(points, lower, upper, side)))
    )


def spacing_from_counts(lower: Floats, upper: Floats, dots: int, count_occupied: Callable[[float], int]) -> float:
    """Return the `typical_spacing` of dots with a bounding box [m] from counts of occupied squares [m].

    ``count_occupied`` returns the number of occupied squares of a side length [m], counted from the lower corner.
    """
    size = np.maximum(upper - lower, 1e-3)
    coarse = max(math.sqrt(size[0] * size[1] / max(dots / 8.0, 1.0)), 1e-4)
    for _ in range(3):
        spacing = math.sqrt(count_occupied(coarse) * coarse * coarse / dots)
        coarse = spacing * math.sqrt(8.0)
    return spacing


def square_indices(points: Floats, lower: Floats, upper: Floats, side: float) -> Ints:
    """Return the indices of the squares of points, counted from the lower corner, shape (N,)."""
    columns = int(max(upper[0] - lower[0], 1e-3) // side) + 1
    column, row = ((points - lower) // side).astype(np.int64).T
    return row * columns + column


def pair_density(grid: DotGrid) -> float:
    """Return the density of other dots around a dot [1/m^2].

    On a uniformly random floor this is the density; on a clustered floor it is higher, and so are chance matches.
    """
    starts = grid.starts.astype(np.int64)
    counts = (starts[1:] - starts[:-1]).reshape(grid.rows, grid.columns)
    return density_from_pairs(count_pairs(counts), len(grid.points), grid.cell)


def count_pairs(counts: Ints) -> int:
    """Return the number of ordered pairs of dots that share a block of cells.

    ``counts``, shape (rows, columns), is the number of dots in each cell; the first row begins a block.
    """
    side = BLOCK_ROWS
    rows, columns = (n // side + 1 for n in counts.shape)
    padded = np.zeros((rows * side, columns * side), dtype=np.int64)
    padded[: counts.shape[0], : counts.shape[1]] = counts
    blocks = padded.reshape(rows, side, columns, side).sum(axis=(1, 3))
    return int(np.sum(blocks * (blocks - 1)))


def density_from_pairs(pairs: int, dots: int, cell: float) -> float:
    """Return the density of `pair_density` from the number of pairs in all blocks [1/m^2]."""
    return max(pairs / dots / (BLOCK_ROWS * cell) ** 2, 1.0 / cell**2)


@njit(cache=True)
def nearest_dot(grid: DotGrid, x: float, y: float, radius: float) -> tuple[int, float]:
    """Return the index of the dot nearest to (x, y) within ``radius`` [m], or -1, and its squared distance [m^2]."""
    first_column = max(int((x - radius - grid.x0) / grid.cell), 0)
    last_column = min(int((x + radius - grid.x0) / grid.cell), grid.columns - 1)
    first_row = max(int((y - radius - grid.y0) / grid.cell), 0)
    last_row = min(int((y + radius - grid.y0) / grid.cell), grid.rows - 1)
    best, best_squared = -1, radius * radius
    if last_column < first_column:
        return best, best_squared
    for row in range(first_row, last_row + 1):
        start = np.int64(grid.starts[row * grid.columns + first_column])
        end = np.int64(grid.starts[row * grid.columns + last_column + 1])
        for i in range(start, end):
            dx = grid.points[i, 0] - x
            dy = grid.points[i, 1] - y
            squared = dx * dx + dy * dy
            if squared < best_squared:
                best, best_squared = i, squared
    return best, best_squared


@njit(cache=True)
def dots_within(grid: DotGrid, x: float, y: float, radius: float, found: Ints) -> int:
    """Write the indices of the dots within ``radius`` [m] of (x, y) to ``found`` and return their number.

    Dots beyond the size of ``found`` are left out.
    """
    first_column = max(int((x - radius - grid.x0) / grid.cell), 0)
    last_column = min(int((x + radius - grid.x0) / grid.cell), grid.columns - 1)
    first_row = max(int((y - radius - grid.y0) / grid.cell), 0)
    last_row = min(int((y + radius - grid.y0) / grid.cell), grid.rows - 1)
    count = 0
    if last_column < first_column:
        return count
    for row in range(first_row, last_row + 1):
        start = np.int64(grid.starts[row * grid.columns + first_column])
        end = np.int64(grid.starts[row * grid.columns + last_column + 1])
        for i in range(start, end):
            dx = grid.points[i, 0] - x
            dy = grid.points[i, 1] - y
            if dx * dx + dy * dy <= radius * radius and count < len(found):
                found[count] = i
                count += 1
    return count
