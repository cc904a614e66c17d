"""Differences of directions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def folded(difference: float, period: float) -> float:
    """Return a difference of directions within half a period: pi for lines, 2 pi for arrows [rad]."""
    return math.remainder(difference, period)


def folded_all(differences: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Return differences of directions of any shape within half a period [rad]."""
    return np.asarray(differences - period * np.rint(differences / period), dtype=np.float64)
