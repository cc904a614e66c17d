"""Geometric hashing: the similarity invariants of six dots, which the index stores and the search looks up.

The two dots farthest apart are the baseline: they are mapped to (0, 0) and (1, 0). The coordinates of the other four,
the inner dots, are then invariant to translation, rotation and scale. Sorted by x, they are the eight numbers of a key.
A key is quantized into cells of an eight-dimensional grid. The cell is hashed to a bucket; the entry also stores the
subcell, which eighth of the cell contains the key along each coordinate.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

OTHERS = 4
"""Number of dots of a constellation other than the two ends of its baseline."""

LANES = 2 * OTHERS

# In the lune, the points closer to both ends of the baseline than its length, x is in 0..1 and y in +-0.866; the rest
# is margin for noise.
X_LOWER, Y_LOWER = -0.1, -1.0
LOWER = (X_LOWER, Y_LOWER)

PARTS = 8
"""Quantization steps per cell along each coordinate."""
PART_BITS = np.uint64(3)
_PART_MASK = np.uint64(PARTS - 1)
_FINEST, _COARSEST = 0.03, 0.3

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
"""Hash increments from a cell to the next one along each coordinate: odd pseudorandom numbers."""


@njit(cache=True)
def base_coordinates(
    points: NDArray[np.float64], first: int, second: int, others: NDArray[np.int64], xy: NDArray[np.float64]
) -> None:
    """Write the coordinates of the inner dots in the frame of a baseline to ``xy``.

    Args:
        points: shape (n, 2), dots [m].
        first: index of the dot at (0, 0).
        second: index of the dot at (1, 0).
        inner_dots: shape (4,), indices of the inner dots.
        xy: shape (4, 2), output: their coordinates [baseline lengths].
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
    """Return the offset of the inner dots' mean x from the middle of the baseline [baseline lengths]."""
    return np.sum(xy[:, 0]) / OTHERS - 0.5


@njit(cache=True)
def turn_around(xy: NDArray[np.float64]) -> None:
    """Swap the ends of the baseline in ``xy``, shape (4, 2), in place."""
    for k in range(OTHERS):
        xy[k, 0] = 1.0 - xy[k, 0]
        xy[k, 1] = -xy[k, 1]


@njit(cache=True)
def sort_by_x(xy: NDArray[np.float64]) -> None:
    """Sort the inner dots, shape (4, 2), by x, in place."""
    for k in range(1, OTHERS):
        x, y = xy[k, 0], xy[k, 1]
        m = k
        while m > 0 and xy[m - 1, 0] > x:
            xy[m, 0], xy[m, 1] = xy[m - 1, 0], xy[m - 1, 1]
            m -= 1
        xy[m, 0], xy[m, 1] = x, y


def cell_step(keys: int, crowding: float) -> float:
    """Return the quantization step, an eighth of a cell's side, for an index of a given size [baseline lengths].

    Fuller cells need fewer reads; emptier cells are so small that noise moves keys out of them.

    The side of an eight-dimensional cell shrinks with the eighth root of the number of keys, so that cells are equally
    full in large and small indices.

    Args:
        keys: number of keys.
        keys_per_cell: mean number of keys per cell.
    """
    side = min(max((crowding / max(keys, 1)) ** (1.0 / LANES), _FINEST), _COARSEST)
    return side / PARTS


@njit(cache=True)
def to_steps(value: float, lower: float, step: float) -> int:
    """Return the quantization step of a coordinate; values below the range are clipped to step 0."""
    return max(int((value - lower) / step), 0)


@njit(cache=True)
def from_steps(steps: int, lower: float, step: float) -> float:
    """Return the coordinate at the centre of a quantization step."""
    return lower + (steps + 0.5) * step


@njit(cache=True)
def cut_into_steps(xy: NDArray[np.float64], step: float, steps: NDArray[np.int64]) -> None:
    """Write the quantized coordinates of the inner dots, shape (4, 2), to ``steps``, shape (8,): x y x y ..."""
    for k in range(OTHERS):
        steps[2 * k] = to_steps(xy[k, 0], X_LOWER, step)
        steps[2 * k + 1] = to_steps(xy[k, 1], Y_LOWER, step)


@njit(cache=True)
def hash_of_steps(steps: NDArray[np.int64]) -> np.uint64:
    """Return the hash of the cell of a quantized key: the next cell along a coordinate is one addition away."""
    mixed = np.uint64(0)
    for k in range(LANES):
        mixed += np.uint64(steps[k] // PARTS) * LANE_HASHES[k]
    return mixed


@njit(cache=True)
def bucket_of_hash(mixed: np.uint64, buckets: int) -> int:
    """Return the bucket, 0 .. buckets - 1 with buckets < 2**32, of a hash: its upper bits are well mixed."""
    return int(((mixed >> np.uint64(32)) * np.uint64(buckets)) >> np.uint64(32))


@njit(cache=True)
def pack_parts(steps: NDArray[np.int64]) -> np.uint64:
    """Return the subcell of a key: three bits per coordinate, the first coordinate uppermost."""
    parts = np.uint64(0)
    for k in range(LANES):
        parts = (parts << PART_BITS) | np.uint64(steps[k] % PARTS)
    return parts


@njit(cache=True)
def part_of_lane(parts: np.uint64, lane: int) -> int:
    """Return the step of a key within its cell, 0 .. 7, along a coordinate."""
    return int((parts >> (PART_BITS * np.uint64(LANES - 1 - lane))) & _PART_MASK)
