"""Reachability by connected components, much faster than a search."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def is_reachable(blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]) -> bool:
    """Return whether there is a route between two free cells that cuts no corner.

    A diagonal step needs both adjacent cells free, so connected cells are connected by straight steps.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns).
        start: row and column of the start, free.
        goal: row and column of the goal, free.
    """
    _, components = cv2.connectedComponents((~blocked).view(np.uint8), connectivity=4)
    return bool(components[start] == components[goal])
