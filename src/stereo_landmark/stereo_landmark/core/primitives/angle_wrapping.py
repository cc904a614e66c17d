"""Wrapping of angle differences to half a period."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def wrap_difference(difference: float, period: float) -> float:
    """Wrap an angle difference to half a period; the period is pi for lines, 2 pi for directions [rad]."""
    return math.remainder(difference, period)


def wrap_differences(differences: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Wrap an array of angle differences to half a period [rad]."""
    return np.asarray(differences - period * np.rint(differences / period), dtype=np.float64)
