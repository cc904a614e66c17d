"""The first unknowns of normal equations eliminated, in tiles that BLAS does with one thread.

So the bits are the same in a worker that may use one thread and in a process that may use all, and no thread waits
for another one on a busy computer: from about 80 unknowns on that takes longer than the work.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky
from scipy.linalg.lapack import dtrtri

# OpenBLAS takes more threads from 64 rows of a factor and from 64 * 64 * 64 products on.
_TILE = 60


def eliminate_first(normal: NDArray[np.float64], gradient: NDArray[np.float64], count: int) -> None:
    """Eliminate the first unknowns, in place.

    Args:
        normal: shape (n, n), symmetric; of it, only the upper triangle is used and written: above, the rows of U with
            U^T U = A_11, whose tiles on the diagonal are inverted, and of X = U^-T A_12; below, A_22 - X^T X.
        gradient: shape (n,); becomes y = U^-T g_1 and g_2 - X^T y.
        count: number of the unknowns that are eliminated.
    """
    size = len(normal)
    for begin in range(0, count, _TILE):
        own = slice(begin, min(begin + _TILE, count))
        # With the inverse of a tile in its place all the rest are products.
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
        upper: shape (count, n), the first rows of what `eliminate_first` has left of the normal equations.
        y: shape (count,), of its gradient.
        known: shape (n - count,), the other unknowns.
    """
    count = len(y)
    found = y - np.einsum('ij,j->i', upper[:, count:], known)
    for begin in range(_TILE * ((count - 1) // _TILE), -1, -_TILE):
        own = slice(begin, min(begin + _TILE, count))
        found[own] = upper[own, own] @ found[own]
        found[:begin] -= np.einsum('ij,j->i', upper[:begin, own], found[own])
    return found
