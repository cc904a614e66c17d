"""Normal equations of some images of a survey, and their partial Cholesky factorisation.

It works in tiles small enough that BLAS uses a single thread.
The result is then bitwise the same in a worker with one thread and in a process with many, and no thread waits for
another on a busy computer, which from about 80 unknowns on takes longer than the work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.lapack import dtrtri

from floor_localizer.core.arrays import Floats, Ints

UNKNOWNS_PER_IMAGE = 6
# OpenBLAS uses several threads from 64 rows of a factor and from 64 * 64 * 64 products on.
_TILE = 60


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations of some images, with six unknowns each.

    Attributes:
        images: indices of the images, ascending, shape (k,).
        normal: symmetric normal matrix, shape (6 k, 6 k).
        gradient: gradient, shape (6 k,).
    """

    images: Ints
    normal: Floats
    gradient: Floats

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Return the sum of both, over the union of their images."""
        images = np.union1d(self.images, other.images)
        total = NormalEquations(
            images,
            np.zeros((UNKNOWNS_PER_IMAGE * len(images), UNKNOWNS_PER_IMAGE * len(images))),
            np.zeros(UNKNOWNS_PER_IMAGE * len(images)),
        )
        for each in (self, other):
            rows = unknown_indices(np.searchsorted(images, each.images))
            total.normal[np.ix_(rows, rows)] += each.normal
            total.gradient[rows] += each.gradient
        return total


def unknown_indices(images: Ints) -> Ints:
    """Return the indices of the unknowns of images, shape (6 k,)."""
    return (UNKNOWNS_PER_IMAGE * images[:, None] + np.arange(UNKNOWNS_PER_IMAGE)).ravel()


def eliminate_leading(normal: Floats, gradient: Floats, count: int) -> None:
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


def back_substitute(upper: Floats, y: Floats, known: Floats) -> Floats:
    """Return the eliminated unknowns, shape (count,), given the others, shape (n - count,).

    ``upper``, shape (count, n), and ``y``, shape (count,), are the first rows of what `eliminate_leading` writes.
    """
    count = len(y)
    solution = y - np.einsum('ij,j->i', upper[:, count:], known)
    for begin in range(_TILE * ((count - 1) // _TILE), -1, -_TILE):
        tile = slice(begin, min(begin + _TILE, count))
        solution[tile] = upper[tile, tile] @ solution[tile]
        solution[:begin] -= np.einsum('ij,j->i', upper[:begin, tile], solution[tile])
    return solution
