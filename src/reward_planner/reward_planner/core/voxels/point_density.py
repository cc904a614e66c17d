"""How dense the points of a cloud are whose camera nobody told."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

_CELL = 0.05  # of the tangents of the angles of view, in which points are counted
_CELLS = 64  # to each side: up to 72 degrees off the axis


def focal_length_of_cloud(points: NDArray[np.float32]) -> float:
    """Return what would be the focal length of a depth camera whose points are as dense, see `SensorView` [px].

    Half of the directions in which there are points have more, half have fewer: a few phantoms, and directions that see
    nothing, play no part. A sparse lidar gets a small one, so that each of its points counts.

    Args:
        points: shape (n, 3), in the sensor's optical frame [m]; what is behind it or not finite is left out.

    Returns:
        0 without points ahead.
    """
    counts = np.zeros(4 * _CELLS**2, dtype=np.int64)
    _count_directions(points, counts)
    filled = counts[counts > 0]
    return float(np.sqrt(np.median(filled)) / _CELL) if len(filled) else 0.0


@njit(cache=True)
def _count_directions(points: NDArray[np.float32], counts: NDArray[np.int64]) -> None:
    """Count points by the tangents of their directions, shape (4 _CELLS^2,)."""
    for x, y, z in points:
        if not z > 0.0:
            continue
        column, row = np.floor(x / z / _CELL) + _CELLS, np.floor(y / z / _CELL) + _CELLS
        if 0 <= column < 2 * _CELLS and 0 <= row < 2 * _CELLS:
            counts[int(row) * 2 * _CELLS + int(column)] += 1
