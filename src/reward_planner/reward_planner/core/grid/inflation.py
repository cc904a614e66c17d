"""Distance transform and inflation of obstacles by the robot's radius."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_ROUNDING = 1e-4  # distances are computed in single precision [cells]


def clearance(occupied: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Return the distance from the centre of each cell to that of the nearest occupied one [m].

    Args:
        occupied: occupied cells, shape (rows, columns).
        resolution: side of a cell [m].

    Returns:
        distances [m], shape (rows, columns); infinite if no cell is occupied.
    """
    if not occupied.any():
        return np.full(occupied.shape, np.inf, dtype=np.float32)
    free = np.logical_not(occupied).astype(np.uint8)
    distances = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distances * np.float32(resolution), dtype=np.float32)


def inflate_obstacles(
    occupied: NDArray[np.bool_], resolution: float, robot_radius: float
) -> NDArray[np.bool_]:
    """Return the occupied cells inflated by the robot's radius: cells that its centre cannot enter.

    Args:
        occupied: occupied cells, shape (rows, columns).
        resolution: side of a cell [m].
        robot_radius: radius of the circle around the robot [m].
    """
    if robot_radius < resolution:
        return occupied.copy()
    return clearance(occupied, resolution) <= robot_radius + _ROUNDING * resolution
