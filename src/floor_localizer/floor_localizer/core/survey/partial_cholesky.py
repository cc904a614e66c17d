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


def eliminate_leading(normal: NDArray[np.float64], gradient: NDArray[np.float64], count: int) -> None:
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
        tile = slice(begin, min(begin + _TILE, count))
        # With the inverse of the diagonal tile, all remaining steps are matrix products.
        normal[tile, tile], _ = dtrtri(cholesky(normal[tile, tile], check_finite=False))
        inverse = normal[tile, tile].T.copy()
        gradient[tile] = inverse @ gradient[tile]
        trailing = [slice(k, min(k + _TILE, size)) for k in range(tile.stop, size, _TILE)]
        for column in trailing:
            normal[tile, column] = inverse @ normal[tile, column]
            gradient[column] -= gradient[tile] @ normal[tile, column]
        for k, row in enumerate(trailing):
            panel = normal[tile, row].T.copy()
            for column in trailing[k:]:
                normal[row, column] -= panel @ normal[tile, column]


def back_substitute(
    upper: NDArray[np.float64], y: NDArray[np.float64], known: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the eliminated unknowns, shape (count,).

    Args:
        upper: first rows of the matrix written by `eliminate_leading`, shape (count, n).
        y: first rows of the gradient written by it, shape (count,).
        known: the other unknowns, shape (n - count,).
    """
    count = len(y)
    solution = y - np.einsum('ij,j->i', upper[:, count:], known)
    for begin in range(_TILE * ((count - 1) // _TILE), -1, -_TILE):
        tile = slice(begin, min(begin + _TILE, count))
        solution[tile] = upper[tile, tile] @ solution[tile]
        solution[:begin] -= np.einsum('ij,j->i', upper[:begin, tile], solution[tile])
    return solution
