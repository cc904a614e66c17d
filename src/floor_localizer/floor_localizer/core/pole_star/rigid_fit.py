"""The pose that takes image dots to floor dots (the last sentence of paper 2.3.2)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2


def fit_pose(image_points: NDArray[np.float64], map_points: NDArray[np.float64]) -> SE2:
    """Return the least-squares pose ``T_map_view`` of paired dots: rotation and translation, without reflection.

    Args:
        image_points: shape (n, 2), dots in the view's frame [m], at least two different points.
        map_points: shape (n, 2), the same dots in the map frame [m].
    """
    image_centre, map_centre = image_points.mean(axis=0), map_points.mean(axis=0)
    a, b = (image_points - image_centre).T, (map_points - map_centre).T
    yaw = math.atan2(float(a[0] @ b[1] - a[1] @ b[0]), float(a[0] @ b[0] + a[1] @ b[1]))
    turn = SE2(0.0, 0.0, yaw)
    shift = map_centre - turn.transform(image_centre)
    return SE2(float(shift[0]), float(shift[1]), yaw)
