"""The inverse of small symmetric matrices within compiled loops, where a call of LAPACK takes longer than the work."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

SINGULAR = 1e-10
"""A row that the rows before it explain but for this share of its diagonal tells nothing new."""


@njit(cache=True, error_model='numpy')
def invert_symmetric(matrix: NDArray[np.float64], inverse: NDArray[np.float64]) -> bool:
    """Write the inverse of a positive definite matrix by Cholesky's decomposition.

    Args:
        matrix: shape (n, n).
        inverse: shape (n, n), filled.

    Returns:
        whether there is one; scaling rows and columns alike changes nothing of that.
    """
    n = len(matrix)
    lower = np.zeros((n, n))
    if not _decompose(matrix, lower):
        return False
    # Column by column the inverse of the lower half, in its place.
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
def _decompose(matrix: NDArray[np.float64], lower: NDArray[np.float64]) -> bool:
    """Write the lower half of Cholesky's decomposition; False where there is none."""
    for j in range(len(matrix)):
        for i in range(j, len(matrix)):
            total = matrix[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i > j:
                lower[i, j] = total / lower[j, j]
            elif total > SINGULAR * matrix[j, j]:
                lower[j, j] = np.sqrt(total)
            else:
                return False
    return True
