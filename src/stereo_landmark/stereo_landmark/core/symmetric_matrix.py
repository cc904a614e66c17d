"""Inverse of small symmetric matrices inside numba kernels, where a LAPACK call costs more than the work itself."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

SINGULAR_TOLERANCE = 1e-10
"""Smallest pivot as a fraction of the diagonal entry; smaller pivots make the matrix singular."""


@njit(cache=True, error_model='numpy')
def invert_symmetric(matrix: NDArray[np.float64], inverse: NDArray[np.float64]) -> bool:
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
def _cholesky(matrix: NDArray[np.float64], lower: NDArray[np.float64]) -> bool:
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
