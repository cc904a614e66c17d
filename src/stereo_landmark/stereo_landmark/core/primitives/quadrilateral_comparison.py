"""Vectorized comparison of quadrilaterals by their corners."""

from __future__ import annotations

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats


@njit(cache=True, error_model='numpy')
def compare_corners(found: Floats, taught: Floats, size_tolerance: float, shape_tolerance: float) -> Floats:
    """Return the differences of detected quadrilaterals from taught ones, shape (k, n); 1 is at the tolerance.

    Args:
        found: vectors from the centre to the four corners [px] and polarity, shape (n, 9).
        taught: parameters of the taught quadrilaterals, shape (k, 9).
        size_tolerance: tolerance of the logarithm of the size.
        shape_tolerance: tolerance of a corner after scaling both to the same size, as a fraction of the size.
    """
    differences = np.full((len(taught), len(found)), np.inf)
    sizes = np.empty(len(found))
    for i in range(len(found)):
        sizes[i] = corner_norm(found[i])
    for k in range(len(taught)):
        size = corner_norm(taught[k])
        for i in range(len(found)):
            if found[i, 8] != taught[k, 8]:
                continue
            scale = sizes[i] / size
            by_size = abs(np.log(scale)) / size_tolerance
            # Beyond the size tolerance the corner order does not matter.
            if by_size > 1.0:
                differences[k, i] = by_size
                continue
            rotation = best_corner_rotation(found[i], taught[k])
            shift = _largest_corner_distance(found[i], taught[k], rotation, scale)
            differences[k, i] = max(by_size, shift / (0.5 * size * shape_tolerance))
    return differences


@njit(cache=True, error_model='numpy')
def best_corner_rotation(found: Floats, taught: Floats) -> int:
    """Return which corner of a detected quadrilateral matches the first corner of a taught one.

    Args:
        found: parameters of the detected quadrilateral, starting with its corner vectors [px], shape (9,).
        taught: parameters of the taught quadrilateral, shape (9,).
    """
    best, most = 0, -np.inf
    for rotation in range(4):
        # The norms are fixed, so the distance is smallest where the dot product is largest.
        product = 0.0
        for c in range(8):
            product += found[(c + 2 * rotation) % 8] * taught[c]
        if product > most:
            best, most = rotation, product
    return best


@njit(cache=True, error_model='numpy')
def order_corner_pairs(left: Floats, right: Floats, taught: Floats) -> Floats:
    """Return the corner vectors in both images in the order of a taught quadrilateral, shape (n, 4, 4) [px].

    Args:
        left: parameters of quadrilaterals in the left image, shape (n, 9).
        right: parameters of the matching quadrilaterals in the right image, shape (n, 9).
        taught: parameters of the taught quadrilateral, shape (9,).
    """
    vectors = np.empty((len(left), 4, 4))
    for i in range(len(left)):
        rotation = best_corner_rotation(left[i], taught)
        other = (rotation + best_corner_rotation(right[i], left[i])) % 4
        for c in range(4):
            for axis in range(2):
                vectors[i, c, axis] = left[i, (2 * (c + rotation) + axis) % 8]
                vectors[i, c, 2 + axis] = right[i, (2 * (c + other) + axis) % 8]
    return vectors


@njit(cache=True, error_model='numpy')
def corner_norm(vectors: Floats) -> float:
    """Return the Frobenius norm of the corner vectors of a quadrilateral, shape (9,) [px]."""
    total = 0.0
    for c in range(8):
        total += vectors[c] ** 2
    return np.sqrt(total)


@njit(cache=True, error_model='numpy')
def _largest_corner_distance(found: Floats, taught: Floats, rotation: int, scale: float) -> float:
    largest = 0.0
    for c in range(4):
        f = (2 * c + 2 * rotation) % 8
        dx, dy = found[f] / scale - taught[2 * c], found[f + 1] / scale - taught[2 * c + 1]
        largest = max(largest, np.sqrt(dx * dx + dy * dy))
    return largest
