"""Whether a way exists at all, which is told much faster than which one is the shortest."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def is_reachable(blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]) -> bool:
    """Return whether routes that cut no corner lead from one free cell to another.

    A diagonal step needs both cells beside it free, so cells that are connected are connected by straight steps.
    A search finds the same, but only after it has been everywhere.

    Args:
        blocked: shape (rows, columns), the cells that the robot cannot enter.
        start: row and column, free.
        goal: row and column, free.
    """
    _, parts = cv2.connectedComponents((~blocked).view(np.uint8), connectivity=4)
    return bool(parts[start] == parts[goal])
