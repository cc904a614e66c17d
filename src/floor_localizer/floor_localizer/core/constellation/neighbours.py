"""For each dot of a view the others from near to far."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

# The first circle holds so many times the dots that are wanted, on average; one near the border holds fewer.
_MORE = 1.5


@njit(cache=True)
def order_neighbours(points: NDArray[np.float64], most: int) -> NDArray[np.int64]:
    """Return for each dot, shape (n, 2), the indices of up to ``most`` others from near to far, shape (n, m)."""
    n = len(points)
    m = max(min(n - 1, most), 0)
    nearest = np.empty((n, m), dtype=np.int64)
    if m == 0:
        return nearest
    squared = np.empty(n)
    near = np.empty(n, dtype=np.int64)
    circle = max(_area(points) * _MORE * m / (math.pi * n), 1e-12)
    for i in range(n):
        for j in range(n):
            dx = points[i, 0] - points[j, 0]
            dy = points[i, 1] - points[j, 1]
            squared[j] = dx * dx + dy * dy
        squared[i] = math.inf
        within = circle
        count = _sort_within(squared, within, near)
        while count < m:
            within *= 3.0
            count = _sort_within(squared, within, near)
        nearest[i] = near[:m]
    return nearest


@njit(cache=True)
def _area(points: NDArray[np.float64]) -> float:
    """Return the area of the box around points, shape (n, 2)."""
    x, y = points[:, 0], points[:, 1]
    return float((np.max(x) - np.min(x)) * (np.max(y) - np.min(y)))


@njit(cache=True)
def _sort_within(squared: NDArray[np.float64], most: float, near: NDArray[np.int64]) -> int:
    """Write the indices of the distances up to ``most`` to ``near`` from small to large and return their number."""
    count = 0
    for j in range(len(squared)):
        if squared[j] <= most:
            k = count
            while k > 0 and squared[near[k - 1]] > squared[j]:
                near[k] = near[k - 1]
                k -= 1
            near[k] = j
            count += 1
    return count
