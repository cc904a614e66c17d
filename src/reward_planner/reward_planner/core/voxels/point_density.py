"""Point density of clouds without a camera model."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

_CELL = 0.05  # bin size of the direction histogram [tangent]
_CELLS = 64  # bins to each side: up to 72 degrees off the axis


def equivalent_focal_length(points: NDArray[np.float32]) -> float:
    """Return the focal length of a depth camera with the same point density, see `SensorView` [px].

    It is the median over the directions with points, so outliers and empty directions have no effect. A sparse lidar
    gets a small value, so that each of its points counts.

    Args:
        points: points in the sensor's optical frame [m], shape (n, 3); those behind it or not finite are ignored.

    Returns:
        focal length [px], 0 without points ahead.
    """
    counts = np.zeros(4 * _CELLS**2, dtype=np.int64)
    _count_directions(points, counts)
    filled = counts[counts > 0]
    return float(np.sqrt(np.median(filled)) / _CELL) if len(filled) else 0.0


@njit(cache=True)
def _count_directions(points: NDArray[np.float32], counts: NDArray[np.int64]) -> None:
    """Count points by direction (tangents), shape (4 _CELLS^2,)."""
    for x, y, z in points:
        if not z > 0.0:
            continue
        column, row = np.floor(x / z / _CELL) + _CELLS, np.floor(y / z / _CELL) + _CELLS
        if 0 <= column < 2 * _CELLS and 0 <= row < 2 * _CELLS:
            counts[int(row) * 2 * _CELLS + int(column)] += 1
