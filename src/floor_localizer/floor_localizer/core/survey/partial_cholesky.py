"""Partial Cholesky factorisation of normal equations, in tiles small enough that BLAS uses a single thread.

The result is then bitwise the same in a worker with one thread and in a process with many, and no thread waits for
another on a busy computer, which from about 80 unknowns on takes longer than the work.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky
from scipy.linalg.lapack import dtrtri

# OpenBLAS uses several threads from 64 rows of a factor and from 64 * 64 * 64 products on.
_TILE = 60


def eliminate_first(normal: NDArray[np.float64], gradient: NDArray[np.float64], count: int) -> None:
    """Eliminate the first unknowns, in place.

    Args:
        normal: symmetric normal matrix, shape (n, n); only the upper triangle is used and overwritten: the upper rows
            with U, where U^T U = A_11 (its diagonal tiles inverted), and X = U^-T A_12; the lower rows with the Schur
            complement A_22 - X^T X.
        gradient: gradient, shape (n,); overwritten with y = U^-T g_1 and g_2 - X^T y.
        count: number of unknowns to eliminate.
    """
    size = len(normal)
    for begin in range(0, count, _TILE):
        own = slice(begin, min(begin + _TILE, count))
        # With the inverse of the diagonal tile, all remaining steps are matrix products.
        normal[own, own], _ = dtrtri(cholesky(normal[own, own], check_finite=False))
        inverse = normal[own, own].T.copy()
        gradient[own] = inverse @ gradient[own]
        behind = [slice(k, min(k + _TILE, size)) for k in range(own.stop, size, _TILE)]
        for column in behind:
            normal[own, column] = inverse @ normal[own, column]
            gradient[column] -= gradient[own] @ normal[own, column]
        for k, row in enumerate(behind):
            left = normal[own, row].T.copy()
            for column in behind[k:]:
                normal[row, column] -= left @ normal[own, column]


def way_back(
    upper: NDArray[np.float64], y: NDArray[np.float64], known: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the eliminated unknowns, shape (count,).

    Args:
        upper: first rows of the matrix written by `eliminate_first`, shape (count, n).
        y: first rows of the gradient written by it, shape (count,).
        known: the other unknowns, shape (n - count,).
    """
    count = len(y)
    found = y - np.einsum('ij,j->i', upper[:, count:], known)
    for begin in range(_TILE * ((count - 1) // _TILE), -1, -_TILE):
        own = slice(begin, min(begin + _TILE, count))
        found[own] = upper[own, own] @ found[own]
        found[:begin] -= np.einsum('ij,j->i', upper[:begin, own], found[own])
    return found
