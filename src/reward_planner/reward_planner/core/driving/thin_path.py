"""Fewer points of long routes, for messages: one of 40 000 poses takes half a second."""

import cv2
import numpy as np
from numpy.typing import NDArray

_DENSE = 500  # points from the robot on that stay as they are


def thin_path(points_map: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Return a path whose straight parts beyond the first points are one segment each (Douglas and Peucker, 1973).

    Args:
        points_map: points [m], shape (n, 2).
        tolerance: largest deviation [m].
    """
    if len(points_map) <= 2 * _DENSE:
        return points_map
    dense, rest = points_map[:_DENSE], points_map[_DENSE:]
    # Relative to its begin, because OpenCV rounds to single precision.
    corners = cv2.approxPolyDP((rest - rest[0]).astype(np.float32)[:, None], tolerance, False)
    return np.concatenate([dense, corners[:-1, 0] + rest[0], rest[-1:]])
