"""The second implementation of shortest routes: scipy's Dijkstra over the graph of all steps."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra


def step_graph(blocked: NDArray[np.bool_]) -> csr_array:
    """Return the steps between free cells; the cell (r, c) has the number r * columns + c."""
    rows, columns = blocked.shape
    numbers = np.arange(rows * columns).reshape(rows, columns)
    free = np.pad(~blocked, 1)
    steps = []
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            if down == right == 0:
                continue
            ways = [(0, 0), (down, right), (down, 0), (0, right)]
            can = np.logical_and.reduce(
                [free[1 + a : 1 + a + rows, 1 + b : 1 + b + columns] for a, b in ways]
            )
            row, column = np.nonzero(can)
            lengths = np.full(len(row), np.hypot(down, right))
            steps.append((numbers[row, column], numbers[row + down, column + right], lengths))
    begins, ends, lengths = (np.concatenate(parts) for parts in zip(*steps))
    return coo_array((lengths, (begins, ends)), shape=(rows * columns, rows * columns)).tocsr()


def distances_from(blocked: NDArray[np.bool_], start: tuple[int, int]) -> NDArray[np.float64]:
    """Return the length of the shortest route to every cell [cells], infinite where there is none."""
    number = start[0] * blocked.shape[1] + start[1]
    return dijkstra(step_graph(blocked), indices=number).reshape(blocked.shape)


def is_driveable(blocked: NDArray[np.bool_], cells: NDArray[np.int64]) -> bool:
    """Return whether every step goes to a neighbour, through free cells and past no blocked corner."""
    if blocked[tuple(cells.T)].any():
        return False
    steps = np.diff(cells, axis=0)
    if len(steps) and not (np.abs(steps).max(axis=1) == 1).all():
        return False
    return not any(
        blocked[row + down, column] or blocked[row, column + right]
        for (row, column), (down, right) in zip(cells[:-1], steps)
    )
