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

# The side of a cell is the eighth root of this over the number of keys: a bucket then fills a cache line or two.
_CROWDING = 0.5
_FINEST, _COARSEST = 0.03, 0.3

# A lane is seven bits of a step and a guard bit above them, which catches the borrow of a subtraction.
_LANE = np.uint64(8)
_LANE_MASK = np.uint64(_LARGEST)
_GUARDS = np.uint64(0x8080808080808080)

LANE_HASHES = np.array(
    [
        0x9E3779B97F4A7C15,
        0xBF58476D1CE4E5B9,
        0x94D049BB133111EB,
        0xD6E8FEB86659FD93,
        0xC2B2AE3D27D4EB4F,
        0xFF51AFD7ED558CCD,
        0xC4CEB9FE1A85EC53,
        0x8EBC6AF09C88C6E3,
    ],
    dtype=np.uint64,
)
"""What a step to the next cell along a lane adds to a hash: odd numbers without a pattern."""


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


def cell_sides(keys: int) -> tuple[int, int]:
    """Return the sides of a hash cell along x and y in steps for an index of so many keys.

    The cells of eight coordinates shrink with the eighth root of the number of keys, so that a cell holds as many in a
    large index as in a small one.
    """
    side = min(max((_CROWDING / max(keys, 1)) ** (1.0 / LANES), _FINEST), _COARSEST)
    return max(round(side * X_STEPS), 1), max(round(side * Y_STEPS), 1)


@njit(cache=True)
def lane_hashes(x_cell: int, y_cell: int) -> NDArray[np.uint64]:
    """Return what each step of each lane adds to a key's hash, shape (8, 128).

    It is a multiple of the number of the step's cell, so that the next cell along a lane is one addition away.
    """
    table = np.empty((LANES, _LARGEST + 1), dtype=np.uint64)
    for k in range(LANES):
        for step in range(_LARGEST + 1):
            table[k, step] = np.uint64(step // (x_cell if k % 2 == 0 else y_cell)) * LANE_HASHES[k]
    return table


@njit(cache=True)
def hash_of_code(code: np.uint64, table: NDArray[np.uint64]) -> np.uint64:
    """Return the hash of the cell of a packed key by the table of `lane_hashes`."""
    mixed = np.uint64(0)
    for k in range(LANES):
        mixed += table[k, np.int64((code >> (_LANE * np.uint64(LANES - 1 - k))) & _LANE_MASK)]
    return mixed


@njit(cache=True)
def bucket_of_hash(mixed: np.uint64, bits: int) -> int:
    """Return the bucket in 0 .. 2**bits - 1 of a hash: its upper bits are well mixed."""
    return int(mixed >> np.uint64(64 - bits))


@njit(cache=True)
def unpack(code: np.uint64, steps: NDArray[np.int64]) -> None:
    """Write the eight steps of a packed key to ``steps``, shape (8,)."""
    for k in range(LANES):
        steps[k] = np.int64((code >> (_LANE * np.uint64(LANES - 1 - k))) & _LANE_MASK)
