"""Edge spread function of pixels, and the empirical Bayes prior on the grey levels along a straight edge.

A step edge is blurred by a Gaussian and integrated over the pixel.

A single profile estimates its two levels from about ten pixels each, which limits the accuracy of its offset. Along a
straight edge the levels mostly change linearly. Their scatter about that line gives the variance of the prior: narrow
under even light, wide at shadows or texture.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.special import ndtr

from stereo_landmark.core.arrays import Floats, Ints

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
    for shift, sign in ((wide + narrow, 1.0), (wide - narrow, -1.0), (-wide + narrow, -1.0), (-wide - narrow, 1.0)):
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


class NormalEquations(NamedTuple):
    """Normal equations of the profiles for level, contrast, shift and blur, shape (k, 4, 4) and (k, 4)."""

    normal: Floats
    rhs: Floats
    squares: Floats
    pixel_counts: Floats


class ProfileFits(NamedTuple):
    """Level, contrast and shift of each profile, shape (k, 3); inverse normal matrices; residual variances."""

    solutions: Floats
    inverses: Floats
    residual_variances: Floats


_PROFILES_MIN = 4
# A profile this many sigmas off the line is an outlier and gets no prior.
_OUTLIER_SIGMAS = 3.5
_ITERATIONS = 3
_MAD_TO_SIGMA = 1.4826
# Smallest standard deviation of the prior, as a fraction of the contrast.
_PRIOR_SIGMA_MIN = 0.002


@njit(cache=True, error_model='numpy')
def add_level_prior(sums: NormalEquations, fits: ProfileFits, noise: float) -> None:
    """Add the prior on the grey levels to the normal equations of the profiles; ``noise`` is that of a pixel."""
    solutions, inverses, residual_variances = fits.solutions, fits.inverses, fits.residual_variances
    solved = np.flatnonzero(~np.isnan(residual_variances))
    if len(solved) < _PROFILES_MIN:
        return
    contrast = np.median(np.abs(solutions[solved, 1]))
    levels, variances, expected = np.empty(len(solved)), np.empty(len(solved)), np.empty(len(solved))
    for inside in range(2):
        for m in range(len(solved)):
            k = solved[m]
            levels[m] = solutions[k, 0] + inside * solutions[k, 1]
            spread = inverses[k, 0, 0] + inside * (2.0 * inverses[k, 0, 1] + inverses[k, 1, 1])
            variances[m] = noise**2 * spread
        scatter = _fit_level_line(solved, len(residual_variances), levels, variances, expected)
        if scatter < 0.0:
            continue
        for m in range(len(solved)):
            residual = levels[m] - expected[m]
            if residual * residual > _OUTLIER_SIGMAS**2 * (variances[m] + scatter):
                continue
            k, weight = solved[m], noise**2 / (scatter + (_PRIOR_SIGMA_MIN * contrast) ** 2)
            for r in range(1 + inside):
                sums.rhs[k, r] += weight * expected[m]
                for c in range(1 + inside):
                    sums.normal[k, r, c] += weight
            sums.squares[k] += weight * expected[m] ** 2


@njit(cache=True, error_model='numpy')
def _fit_level_line(numbers: Ints, count: int, levels: Floats, variances: Floats, expected: Floats) -> float:
    """Fit a line robustly to the levels of some profiles and write its values, all of shape (n,) [grey levels].

    Returns:
        variance of the scatter that noise does not explain [grey levels²]; negative with too few inliers.
    """
    expected[:] = np.median(levels)
    scatter = (_MAD_TO_SIGMA * np.median(np.abs(levels - expected))) ** 2
    for _ in range(_ITERATIONS):
        sums, inlier_count = np.zeros(5), 0
        for m in range(len(levels)):
            if (levels[m] - expected[m]) ** 2 > _OUTLIER_SIGMAS**2 * (variances[m] + scatter):
                continue
            weight, position = 1.0 / (variances[m] + scatter), (numbers[m] + 0.5) / count - 0.5
            inlier_count += 1
            for power in range(3):
                sums[power] += weight * position**power
            sums[3] += weight * levels[m]
            sums[4] += weight * position * levels[m]
        determinant = sums[0] * sums[2] - sums[1] ** 2
        if inlier_count < _PROFILES_MIN or determinant <= 0.0:
            return -1.0
        slope = (sums[0] * sums[4] - sums[1] * sums[3]) / determinant
        middle = (sums[3] - slope * sums[1]) / sums[0]
        excess, degrees_of_freedom = 0.0, inlier_count - 2.0
        for m in range(len(levels)):
            residual = levels[m] - expected[m]
            is_inlier = residual * residual <= _OUTLIER_SIGMAS**2 * (variances[m] + scatter)
            expected[m] = middle + slope * ((numbers[m] + 0.5) / count - 0.5)
            if is_inlier:
                excess += (levels[m] - expected[m]) ** 2 - variances[m] * degrees_of_freedom / inlier_count
        scatter = max(excess / degrees_of_freedom, 0.0)
    return scatter
