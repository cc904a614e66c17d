"""Small least squares problems inside numba kernels, where a LAPACK call costs more than the work itself."""

from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats

SINGULAR_TOLERANCE = 1e-10
"""Smallest pivot as a fraction of the diagonal entry; smaller pivots make the matrix singular."""


@njit(cache=True, error_model='numpy')
def invert_symmetric(matrix: Floats, inverse: Floats) -> bool:
    """Write the inverse of a positive definite matrix by Cholesky decomposition.

    Args:
        matrix: symmetric matrix, shape (n, n).
        inverse: output, shape (n, n).

    Returns:
        whether the matrix is invertible; the test does not depend on the units of the rows and columns.
    """
    n = len(matrix)
    lower = np.zeros((n, n))
    if not _cholesky(matrix, lower):
        return False
    # Invert the lower triangle in place, column by column.
    for j in range(n):
        lower[j, j] = 1.0 / lower[j, j]
        for i in range(j + 1, n):
            total = 0.0
            for k in range(j, i):
                total -= lower[i, k] * lower[k, j]
            lower[i, j] = total / lower[i, i]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, n):
                total += lower[k, i] * lower[k, j]
            inverse[i, j] = inverse[j, i] = total
    return True


@njit(cache=True, error_model='numpy')
def _cholesky(matrix: Floats, lower: Floats) -> bool:
    """Write the lower triangle of the Cholesky decomposition; False if the matrix is not positive definite."""
    for j in range(len(matrix)):
        for i in range(j, len(matrix)):
            total = matrix[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i > j:
                lower[i, j] = total / lower[j, j]
            elif total > SINGULAR_TOLERANCE * matrix[j, j]:
                lower[j, j] = np.sqrt(total)
            else:
                return False
    return True


# Tukey's biweight: zero weight beyond this many sigmas.
_TUKEY = 4.7
# Variance increase by Tukey's weights for normally distributed offsets.
_TUKEY_LOSS = 1.05
_ITERATIONS = 5
# Initial iterations minimise the sum of absolute deviations, which one-sided outliers bias less.
_L1_ITERATIONS = 4
_MAD_TO_SIGMA = 1.4826


class RobustStep(NamedTuple):
    """Parameter step, its covariance, and the inlier fraction.

    Attributes:
        found: whether there are enough measured offsets and inliers; otherwise the other values are invalid.
        step: correction of the parameters, shape (p,).
        covariance: covariance of the step, scaled up if the scatter exceeds the noise, shape (p, p).
        inlier_fraction: fraction of inliers among all offsets.
    """

    found: bool
    step: Floats
    covariance: Floats
    inlier_fraction: float


@njit(cache=True, error_model='numpy')
def robust_step(jacobian: Floats, offsets: Floats, sigmas: Floats, prior: Floats) -> RobustStep:
    """Fit a parameter step to the offsets of edge profiles.

    Args:
        jacobian: derivatives of the offset of each profile by the parameters, shape (k, p).
        offsets: measured offsets, shape (k,) [px].
        sigmas: standard deviations of the offsets, infinite for unmeasured ones, shape (k,) [px].
        prior: prior information (inverse variance) of each parameter step, 0 for none, shape (p,).
    """
    measured, unknowns, count = np.isfinite(sigmas), jacobian.shape[1], len(sigmas)
    jacobian, offsets, sigmas = jacobian[measured], offsets[measured], sigmas[measured]
    step, inverse = np.zeros(unknowns), np.eye(unknowns)
    weights, residuals = np.ones(len(sigmas)), np.zeros(len(sigmas))
    for iteration in range(_L1_ITERATIONS + _ITERATIONS):
        if np.sum(weights > 0.0) < unknowns + 1:
            return RobustStep(False, step, inverse, 0.0)
        if not _solve(jacobian, offsets, weights / sigmas**2, prior, step, inverse):
            return RobustStep(False, step, inverse, 0.0)
        residuals = np.abs(offsets - jacobian @ step) / sigmas
        if iteration < _L1_ITERATIONS:
            weights = 1.0 / np.maximum(residuals, 1.0)
            continue
        scale = max(1.0, _MAD_TO_SIGMA * np.median(residuals))
        weights = np.maximum(0.0, 1.0 - (residuals / (_TUKEY * scale)) ** 2) ** 2
    inliers = weights > 0.0
    degrees_of_freedom = np.sum(inliers) - unknowns
    if degrees_of_freedom < 1 or not _solve(jacobian, offsets, inliers / sigmas**2, prior, step.copy(), inverse):
        return RobustStep(False, step, inverse, 0.0)
    scatter = max(1.0, np.sum(residuals[inliers] ** 2) / degrees_of_freedom)
    return RobustStep(True, step, inverse * (scatter * _TUKEY_LOSS), np.sum(inliers) / count)


@njit(cache=True, error_model='numpy')
def _solve(jacobian: Floats, offsets: Floats, weights: Floats, prior: Floats, step: Floats, inverse: Floats) -> bool:
    """Write the weighted least squares step and the inverse of its normal matrix; False if that is singular."""
    weighted = jacobian * weights.reshape(-1, 1)
    if not invert_symmetric(np.diag(prior) + weighted.T @ jacobian, inverse):
        return False
    step[:] = inverse @ (offsets @ weighted)
    return True
