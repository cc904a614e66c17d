"""Escape path (recovery) of a robot that is too near to an obstacle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_NEIGHBOURS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)])


def escape_path(
    clearance: NDArray[np.float32], blocked: NDArray[np.bool_], start: tuple[int, int]
) -> NDArray[np.int64] | None:
    """Return the path of steepest clearance ascent from a start to the first free cell.

    Args:
        clearance: distance to the nearest obstacle [m], shape (rows, columns).
        blocked: blocked cells, shape (rows, columns).
        start: row and column of the start, inside of the grid.

    Returns:
        rows and columns, shape (n, 2), only the start if it is free; None if clearance stops growing before.
    """
    cells = [start]
    while blocked[cells[-1]]:
        around = _NEIGHBOURS + cells[-1]
        inside = ((around >= 0) & (around < clearance.shape)).all(axis=1)
        around = around[inside]
        gains = clearance[around[:, 0], around[:, 1]] - clearance[cells[-1]]
        gains /= np.hypot(*(around - cells[-1]).T)
        best = int(gains.argmax())
        if gains[best] <= 0.0:
            return None
        cells.append((int(around[best, 0]), int(around[best, 1])))
    return np.array(cells, dtype=np.int64)
