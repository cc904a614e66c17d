"""The invariants of six dots under shift, turn and scale: what the index stores and the search looks up.

The two dots farthest apart are the base: the first is put at (0, 0), the second at (1, 0). The other four then have
coordinates that neither shift, turn nor scale changes; in order of their x they make eight numbers, kept in eight
lanes of one 64-bit word.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

OTHERS = 4
"""Dots of a constellation besides its base."""

LANES = 2 * OTHERS

# Inside the lens of points that are nearer to both ends of the base than its length, x is in 0..1 and y in +-0.866;
# the rest is room for noise.
X_LOWER, X_SPAN = -0.1, 1.2
Y_LOWER, Y_SPAN = -1.0, 2.0
_LARGEST = 127
X_STEPS = _LARGEST / X_SPAN
Y_STEPS = _LARGEST / Y_SPAN

# Side of a hash cell in steps: about three times the tolerance at the paper's 1 px of noise.
X_CELL, Y_CELL = 16, 10
_X_CELLS, _Y_CELLS = _LARGEST // X_CELL + 1, _LARGEST // Y_CELL + 1

# A lane is seven bits of a step and a guard bit above them, which catches the borrow of a subtraction.
_LANE = np.uint64(8)
_LANE_MASK = np.uint64(_LARGEST)
_GUARDS = np.uint64(0x8080808080808080)


@njit(cache=True)
def to_steps(value: float, lower: float, steps: float) -> int:
    """Return a coordinate as a whole number of steps in 0..127."""
    return min(max(int((value - lower) * steps + 0.5), 0), _LARGEST)


@njit(cache=True)
def base_coordinates(
    points: NDArray[np.float64], first: int, second: int, others: NDArray[np.int64], xy: NDArray[np.float64]
) -> None:
    """Write the coordinates of the other dots in the frame of a base to ``xy``.

    Args:
        points: shape (n, 2), dots [m].
        first: index of the dot at (0, 0).
        second: index of the dot at (1, 0).
        others: shape (4,), indices of the other dots.
        xy: shape (4, 2), written: their coordinates in units of the base's length.
    """
    ex = points[second, 0] - points[first, 0]
    ey = points[second, 1] - points[first, 1]
    squared = ex * ex + ey * ey
    for k in range(OTHERS):
        dx = points[others[k], 0] - points[first, 0]
        dy = points[others[k], 1] - points[first, 1]
        xy[k, 0] = (dx * ex + dy * ey) / squared
        xy[k, 1] = (dy * ex - dx * ey) / squared


@njit(cache=True)
def imbalance(xy: NDArray[np.float64]) -> float:
    """Return how far the mean x of the others is beyond the middle of the base, in units of its length."""
    return np.sum(xy[:, 0]) / OTHERS - 0.5


@njit(cache=True)
def turn_around(xy: NDArray[np.float64]) -> None:
    """Exchange the ends of the base in ``xy``, shape (4, 2), in place."""
    for k in range(OTHERS):
        xy[k, 0] = 1.0 - xy[k, 0]
        xy[k, 1] = -xy[k, 1]


@njit(cache=True)
def sort_by_x(xy: NDArray[np.float64]) -> None:
    """Put the others, shape (4, 2), in order of their x, in place."""
    for k in range(1, OTHERS):
        x, y = xy[k, 0], xy[k, 1]
        m = k
        while m > 0 and xy[m - 1, 0] > x:
            xy[m, 0], xy[m, 1] = xy[m - 1, 0], xy[m - 1, 1]
            m -= 1
        xy[m, 0], xy[m, 1] = x, y


@njit(cache=True)
def pack_coordinates(xy: NDArray[np.float64]) -> np.uint64:
    """Return the coordinates of the others, shape (4, 2), as one number."""
    code = np.uint64(0)
    for k in range(OTHERS):
        code = (code << _LANE) | np.uint64(to_steps(xy[k, 0], X_LOWER, X_STEPS))
        code = (code << _LANE) | np.uint64(to_steps(xy[k, 1], Y_LOWER, Y_STEPS))
    return code


@njit(cache=True)
def pack(steps: NDArray[np.int64]) -> np.uint64:
    """Return eight steps in 0..127, shape (8,) in the order x y x y ..., as one number."""
    code = np.uint64(0)
    for k in range(LANES):
        code = (code << _LANE) | np.uint64(steps[k])
    return code


@njit(cache=True)
def is_within(code: np.uint64, lower: np.uint64, upper: np.uint64) -> bool:
    """Tell whether all eight steps of a packed key lie between those of two others, ends included."""
    return (((code | _GUARDS) - lower) & ((upper | _GUARDS) - code) & _GUARDS) == _GUARDS


@njit(cache=True)
def bucket_of_cells(cells: NDArray[np.int64], bits: int) -> int:
    """Return the bucket in 0 .. 2**bits - 1 of eight hash cells, shape (8,)."""
    number = np.uint64(0)
    for k in range(OTHERS):
        number = number * np.uint64(_X_CELLS) + np.uint64(cells[2 * k])
        number = number * np.uint64(_Y_CELLS) + np.uint64(cells[2 * k + 1])
    # Fibonacci hashing: the upper bits of the product are well mixed.
    return int((number * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(64 - bits))


@njit(cache=True)
def bucket_of_code(code: np.uint64, bits: int, cells: NDArray[np.int64]) -> int:
    """Return the bucket of a packed key; ``cells``, shape (8,), is room to work in."""
    for k in range(LANES):
        step = np.int64((code >> (_LANE * np.uint64(LANES - 1 - k))) & _LANE_MASK)
        cells[k] = step // X_CELL if k % 2 == 0 else step // Y_CELL
    return bucket_of_cells(cells, bits)
