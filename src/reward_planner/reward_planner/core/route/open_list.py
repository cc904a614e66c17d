"""The open list of a search: a 4-ary heap in plain arrays."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


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
