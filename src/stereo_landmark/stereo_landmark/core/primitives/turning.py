"""Differences of directions."""

from __future__ import annotations

import math


def folded(difference: float, period: float) -> float:
    """Return a difference of directions within half a period: pi for lines, 2 pi for arrows [rad]."""
    return math.remainder(difference, period)


def larger_of(*differences: float) -> float:
    """Return the largest of some differences, whatever their sign."""
    return max(abs(difference) for difference in differences)
