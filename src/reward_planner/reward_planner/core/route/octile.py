"""Lengths of routes of straight and diagonal steps, in whole numbers that compare as the true lengths do.

A diagonal step is sqrt(2) times a straight one. 665857/470832 is a convergent of sqrt(2), so no fraction with a smaller
denominator lies between the two: sums of these whole numbers order two routes as their true lengths do, and
tell them equal only when they are, as long as their numbers of diagonal steps differ by less than 470832.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

STRAIGHT = 470832
DIAGONAL = 665857


@njit(cache=True)
def octile_units(row_a: int, column_a: int, row_b: int, column_b: int) -> int:
    """Return the length of a route between two cells where nothing is in the way [1/STRAIGHT cells]."""
    rows, columns = abs(row_a - row_b), abs(column_a - column_b)
    if rows < columns:
        rows, columns = columns, rows
    return STRAIGHT * (rows - columns) + DIAGONAL * columns


@njit(cache=True)
def route_length(cells: NDArray[np.int64]) -> float:
    """Return the length of a route from cell to neighbouring cell [cells].

    Args:
        cells: shape (n, 2), row and column.
    """
    diagonal = 0
    for k in range(1, len(cells)):
        if cells[k, 0] != cells[k - 1, 0] and cells[k, 1] != cells[k - 1, 1]:
            diagonal += 1
    return len(cells) - 1 - diagonal + diagonal * math.sqrt(2.0)
