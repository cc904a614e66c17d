"""Empirical Bayes prior on the grey levels of edge profiles along a straight edge.

A single profile estimates its two levels from about ten pixels each, which limits the accuracy of its offset. Along a
straight edge the levels mostly change linearly. Their scatter about that line gives the variance of the prior: narrow
under even light, wide at shadows or texture.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints

_PROFILES_MIN = 4
# A profile this many sigmas off the line is an outlier and gets no prior.
_OUTLIER_SIGMAS = 3.5
_ITERATIONS = 3
_MAD_TO_SIGMA = 1.4826
# Smallest standard deviation of the prior, as a fraction of the contrast.
_PRIOR_SIGMA_MIN = 0.002


@njit(cache=True, error_model='numpy')
def add_level_prior(
    normal: Floats,
    rhs: Floats,
    squares: Floats,
    solutions: Floats,
    inverses: Floats,
    residual_variances: Floats,
    noise: float,
) -> None:
    """Add the prior on the grey levels to the normal equations of the profiles.

    Args:
        normal: normal matrices, shape (k, 4, 4); the first unknown is the outer level, the second the contrast.
        rhs: right-hand sides, shape (k, 4).
        squares: sums of squares of the observed values, shape (k,).
        solutions: solutions of the profiles without prior, shape (k, 3).
        inverses: inverses of their normal matrices, shape (k, 3, 3).
        residual_variances: residual variances, NaN for unsolved profiles, shape (k,).
        noise: standard deviation of the pixel noise [grey levels].
    """
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
                rhs[k, r] += weight * expected[m]
                for c in range(1 + inside):
                    normal[k, r, c] += weight
            squares[k] += weight * expected[m] ** 2


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
