"""How much the corners of quadrilaterals differ from those of others, for many at once."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, error_model='numpy')
def corner_differences(
    found: NDArray[np.float64], taught: NDArray[np.float64], size_tolerance: float, shape_tolerance: float
) -> NDArray[np.float64]:
    """Return how much found quadrilaterals differ from taught ones, shape (k, n): 1 is just tolerated.

    Args:
        found: shape (n, 9), the vectors from the centre to the four corners [px] and the polarity.
        taught: shape (k, 9).
        size_tolerance: difference of the logarithm of the size.
        shape_tolerance: of a corner after both were made equally large, as a part of the size.
    """
    differences = np.full((len(taught), len(found)), np.inf)
    sizes = np.empty(len(found))
    for i in range(len(found)):
        sizes[i] = vector_length(found[i])
    for k in range(len(taught)):
        size = vector_length(taught[k])
        for i in range(len(found)):
            if found[i, 8] != taught[k, 8]:
                continue
            scale = sizes[i] / size
            by_size = abs(np.log(scale)) / size_tolerance
            # What is of another size is not turned: it is not tolerated anyhow.
            if by_size > 1.0:
                differences[k, i] = by_size
                continue
            turn = best_turn(found[i], taught[k])
            shift = _largest_shift(found[i], taught[k], turn, scale)
            differences[k, i] = max(by_size, shift / (0.5 * size * shape_tolerance))
    return differences


@njit(cache=True, error_model='numpy')
def best_turn(found: NDArray[np.float64], taught: NDArray[np.float64]) -> int:
    """Return which corner of a found quadrilateral is the first one of a taught one.

    Args:
        found: shape (9,), the vectors from the centre to the corners first [px].
        taught: shape (9,).
    """
    best, most = 0, -np.inf
    for turn in range(4):
        # The vectors keep their lengths, so that they are nearest where their product is largest.
        product = 0.0
        for c in range(8):
            product += found[(c + 2 * turn) % 8] * taught[c]
        if product > most:
            best, most = turn, product
    return best


@njit(cache=True, error_model='numpy')
def ordered_pairs(
    left: NDArray[np.float64], right: NDArray[np.float64], taught: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the corner vectors in both images in the order of a taught quadrilateral, shape (n, 4, 4) [px].

    Args:
        left: shape (n, 9), of quadrilaterals in the left image.
        right: shape (n, 9), of the same in the right one.
        taught: shape (9,).
    """
    vectors = np.empty((len(left), 4, 4))
    for i in range(len(left)):
        turn = best_turn(left[i], taught)
        other = (turn + best_turn(right[i], left[i])) % 4
        for c in range(4):
            for axis in range(2):
                vectors[i, c, axis] = left[i, (2 * (c + turn) + axis) % 8]
                vectors[i, c, 2 + axis] = right[i, (2 * (c + other) + axis) % 8]
    return vectors


@njit(cache=True, error_model='numpy')
def vector_length(vectors: NDArray[np.float64]) -> float:
    """Return the root of the sum of squares of the corner vectors, shape (9,) [px]."""
    total = 0.0
    for c in range(8):
        total += vectors[c] ** 2
    return np.sqrt(total)


@njit(cache=True, error_model='numpy')
def _largest_shift(found: NDArray[np.float64], taught: NDArray[np.float64], turn: int, scale: float) -> float:
    largest = 0.0
    for c in range(4):
        f = (2 * c + 2 * turn) % 8
        dx, dy = found[f] / scale - taught[2 * c], found[f + 1] / scale - taught[2 * c + 1]
        largest = max(largest, np.sqrt(dx * dx + dy * dy))
    return largest
