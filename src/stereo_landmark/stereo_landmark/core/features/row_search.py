"""Searches the row of a feature in the right image for the pixel that looks the same (normalized correlation)."""

from __future__ import annotations

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints, Masks

RADIUS = 5
"""Half the side of the compared squares [px]."""
CORRELATION_MIN = 0.75
UNIQUENESS_MIN = 0.03
"""Minimum difference of the best correlation to that of another disparity."""
BEST_WIDTH = 2
"""Disparities that far from the best one belong to it [px]."""


def search_rows(
    left: Floats, right: Floats, pixels: Floats, limits: tuple[float, float]
) -> tuple[Floats, Masks]:
    """Return the disparities of features to a pixel, shape (n,) [px], and which of them are unique, shape (n,).

    Args:
        left: left image, shape (h, w).
        right: right image, shape (h, w).
        pixels: features in the left image, shape (n, 2) [px].
        limits: smallest and largest disparity [px].
    """
    disparities, unique = np.zeros(len(pixels)), np.zeros(len(pixels), dtype=np.bool_)
    low, high = (round(limit) for limit in limits)
    _search(left, right, np.rint(pixels).astype(np.int64), low, high, disparities, unique)
    return disparities, unique


@njit(cache=True, error_model='numpy')
def _search(
    left: Floats, right: Floats, pixels: Ints, lowest: int, highest: int, disparities: Floats, unique: Masks
) -> None:
    """Write disparity and uniqueness of each feature."""
    side = 2 * RADIUS + 1
    patch = np.empty((side, side), np.float64)
    for n in range(len(pixels)):
        u, v = pixels[n]
        if not (RADIUS <= v < left.shape[0] - RADIUS and RADIUS <= u < left.shape[1] - RADIUS):
            continue
        low, high = max(lowest, u + RADIUS + 1 - right.shape[1]), min(highest, u - RADIUS)
        if high < low:
            continue
        for i in range(side):
            for j in range(side):
                patch[i, j] = left[v - RADIUS + i, u - RADIUS + j]
        patch -= np.mean(patch)
        norm = np.sqrt(np.sum(patch * patch)) + 1e-9
        scores = np.empty(high - low + 1)
        for d in range(low, high + 1):
            cross, total, squares = 0.0, 0.0, 0.0
            for i in range(side):
                for j in range(side):
                    level = right[v - RADIUS + i, u - d - RADIUS + j]
                    cross += patch[i, j] * level
                    total += level
                    squares += level * level
            spread = squares - total * total / side**2
            scores[d - low] = cross / (norm * np.sqrt(spread)) if spread > 1e-6 else -1.0
        best = int(np.argmax(scores))
        disparities[n] = best + low
        second = -1.0
        for k in range(len(scores)):
            if abs(k - best) > BEST_WIDTH:
                second = max(second, scores[k])
        unique[n] = scores[best] >= CORRELATION_MIN and scores[best] - second >= UNIQUENESS_MIN
