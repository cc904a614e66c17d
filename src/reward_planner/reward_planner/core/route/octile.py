"""Octile lengths as integers that compare exactly as the true lengths do.

A diagonal step is sqrt(2) times a straight one. 665857/470832 is a convergent of sqrt(2), so no fraction with a smaller
denominator is between the two. Sums of these integers order two routes as their true lengths do, and are equal only if
those are, as long as their numbers of diagonal steps differ by less than 470832.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

STRAIGHT = 470832
DIAGONAL = 665857


@njit(cache=True)
def octile_distance(row_a: int, column_a: int, row_b: int, column_b: int) -> int:
    """Return the octile distance between two cells [1/STRAIGHT cells]."""
    rows, columns = abs(row_a - row_b), abs(column_a - column_b)
    if rows < columns:
        rows, columns = columns, rows
    return STRAIGHT * (rows - columns) + DIAGONAL * columns


@njit(cache=True)
def route_length(cells: NDArray[np.int64]) -> float:
    """Return the length of a route of neighbouring cells [cells].

    Args:
        cells: rows and columns, shape (n, 2).
    """
    diagonal = 0
    for k in range(1, len(cells)):
        if cells[k, 0] != cells[k - 1, 0] and cells[k, 1] != cells[k - 1, 1]:
            diagonal += 1
    return len(cells) - 1 - diagonal + diagonal * math.sqrt(2.0)
