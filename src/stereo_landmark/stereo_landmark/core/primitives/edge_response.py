"""Edge spread function: response of pixels to a step edge, blurred by a Gaussian and integrated over the pixel."""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit
from scipy.special import ndtr

from stereo_landmark.core.arrays import Floats

BLURS: Floats = np.geomspace(0.1, 5.0, 28)
"""Tabulated standard deviations of the blur [px]."""

REACH = 9.0
"""Largest distance from the edge in the table [px]."""

PIXEL_VARIANCE = 1.0 / 12.0
"""Variance that the pixel's square adds to the blur, in any direction [px²]."""

_STEP = 0.05
_DIRECTIONS = 7
# Smallest angle between edge and image axis; smaller angles make no relevant difference [rad].
_TILT_MIN = 0.02


@cache
def response_table() -> Floats:
    """Return the response, its slope along the distance and its derivative by the blur.

    Returns:
        table, shape (blurs, directions, distances, 3); the response rises from 0 to 1 across the edge.
    """
    angles = np.linspace(0.0, 0.25 * np.pi, _DIRECTIONS)
    distances = np.arange(-REACH, REACH + 0.5 * _STEP, _STEP)
    table = np.empty((len(BLURS), _DIRECTIONS, len(distances), 3))
    for b, blur in enumerate(BLURS):
        for a, angle in enumerate(angles):
            table[b, a] = edge_response(distances, blur, angle)
    return table


def edge_response(distances: Floats, blur: float, angle: float) -> Floats:
    """Return the response, its slope and its derivative by the blur, shape (n, 3).

    Projected on the edge normal, the pixel's square is the convolution of two boxes; a step convolved with a
    Gaussian and two boxes is a second difference of the Gaussian's third integral.

    Args:
        distances: distances of the pixel centres from the edge, shape (n,) [px].
        blur: standard deviation of the blur [px].
        angle: angle between the edge normal and the nearer image axis [rad].
    """
    wide = 0.5 * np.cos(angle)
    narrow = 0.5 * max(np.sin(angle), _TILT_MIN)
    total = np.zeros((len(distances), 3))
    for shift, sign in (
        (wide + narrow, 1.0),
        (wide - narrow, -1.0),
        (-wide + narrow, -1.0),
        (-wide - narrow, 1.0),
    ):
        z = (distances + shift) / blur
        area, density = ndtr(z), np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
        second = 0.5 * blur**2 * ((z * z + 1.0) * area + z * density)
        total += sign * np.column_stack([second, blur * (z * area + density), blur * area])
    return total / (4.0 * wide * narrow)


@njit(cache=True, error_model='numpy')
def nearest_blur(blur: float) -> int:
    """Return the table index of the blur that is nearest in ratio."""
    number = np.rint(np.log(max(blur, 1e-3) / BLURS[0]) / np.log(BLURS[-1] / BLURS[0]) * (len(BLURS) - 1))
    return min(max(int(number), 0), len(BLURS) - 1)


@njit(cache=True, error_model='numpy')
def direction_bin(nx: float, ny: float) -> int:
    """Return the table index of the direction nearest to a unit normal."""
    angle = np.arctan2(min(abs(nx), abs(ny)), max(abs(nx), abs(ny)))
    return int(np.rint(angle / (0.25 * np.pi) * (_DIRECTIONS - 1)))


@njit(cache=True, error_model='numpy')
def interpolate_response(curve: Floats, distance: float, response: Floats) -> None:
    """Write the response, its slope and its derivative by the blur at a distance, by linear interpolation.

    Args:
        curve: one blur and direction of the table, shape (distances, 3).
        distance: distance from the edge, within the table [px].
        response: output, shape (3,).
    """
    position = (distance + REACH) / _STEP
    k = min(max(int(position), 0), len(curve) - 2)
    fraction = position - k
    for c in range(3):
        response[c] = curve[k, c] + fraction * (curve[k + 1, c] - curve[k, c])
