"""Fraction of a pixel that a straight edge covers, by the integral of a clipped line."""

from numba import njit


@njit(cache=True, error_model='numpy')
def clip_integral(t: float) -> float:
    """Return the integral of clip(s, 0, 1) over s from 0 to t."""
    if t <= 0.0:
        return 0.0
    return 0.5 * t * t if t < 1.0 else t - 0.5
