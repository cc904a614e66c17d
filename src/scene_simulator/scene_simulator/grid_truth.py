"""Ground truth of shortest paths in grid worlds: Dijkstra over the graph of all steps.

Steps go to the eight neighbours, straight ones are 1 and diagonal ones sqrt(2) cells long, and no corner is cut.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra


def step_graph(blocked: NDArray[np.bool_]) -> csr_array[np.float64, tuple[int, int]]:
    """Return the steps between free cells; the cell (r, c) has the number r * columns + c.

    Args:
        blocked: shape (rows, columns).
    """
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
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    graph: csr_array[np.float64, tuple[int, int]] | None = None,
) -> NDArray[np.float64]:
    """Return the length of the shortest route to every cell [cells], infinite where there is none.

    Args:
        blocked: shape (rows, columns).
        start: row and column.
        graph: precomputed `step_graph`, for many starts.

    Returns:
        shape (rows, columns).
    """
    number = start[0] * blocked.shape[1] + start[1]
    return np.asarray(dijkstra(step_graph(blocked) if graph is None else graph, indices=number)).reshape(
        blocked.shape
    )


def is_traversable(blocked: NDArray[np.bool_], cells: NDArray[np.int64]) -> bool:
    """Return whether every step is to a neighbour, through free cells, without cutting corners.

    Args:
        blocked: shape (rows, columns).
        cells: shape (n, 2), row and column.
    """
    (rows, columns), (downs, rights) = cells.T, np.diff(cells, axis=0).T
    near = bool((np.maximum(np.abs(downs), np.abs(rights)) == 1).all())
    hits = blocked[rows, columns].any()
    cuts = blocked[rows[:-1] + downs, columns[:-1]] | blocked[rows[:-1], columns[:-1] + rights]
    return near and not hits and not cuts.any()
