"""The cells that a search has yet to look at: a heap with four children a node, over plain arrays."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def push(keys: NDArray[np.int64], cells: NDArray[np.int32], size: int, key: int, cell: int) -> None:
    """Add a cell to a heap of so many; the arrays must have room for it."""
    child = size
    while child:
        parent = (child - 1) >> 2
        if keys[parent] <= key:
            break
        keys[child], cells[child] = keys[parent], cells[parent]
        child = parent
    keys[child], cells[child] = key, cell


@njit(cache=True)
def drop_first(keys: NDArray[np.int64], cells: NDArray[np.int32], size: int) -> None:
    """Take the cell with the least key, at place 0, out of a heap of so many; one less is left."""
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
