"""The invariants of six dots under shift, turn and scale: what the index stores and the search looks up.

The two dots farthest apart are the base: the first is put at (0, 0), the second at (1, 0). The other four then have
coordinates that neither shift, turn nor scale changes; in order of their x they make eight numbers, the lanes of a
key.
A key lies in a cell of the eight-dimensional grid; the cell is hashed to a bucket, and what is kept of the key besides
is in which eighth of the cell it lies along each lane.
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
X_LOWER, Y_LOWER = -0.1, -1.0
LOWER = (X_LOWER, Y_LOWER)

PARTS = 8
"""A cell is so many steps wide along each lane."""
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
"""What a step to the next cell along a lane adds to a hash: odd numbers without a pattern."""


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


def cell_step(keys: int, crowding: float) -> float:
    """Return the side of a step, an eighth of a cell's, in units of the base's length for an index of so many keys.

    More keys in a cell are read at once; fewer make cells so fine that noise leaves them.

    The cells of eight coordinates shrink with the eighth root of the number of keys, so that a cell holds as many in a
    large index as in a small one.

    Args:
        keys: number of keys.
        crowding: how many share a cell.
    """
    side = min(max((crowding / max(keys, 1)) ** (1.0 / LANES), _FINEST), _COARSEST)
    return side / PARTS


@njit(cache=True)
def to_steps(value: float, lower: float, step: float) -> int:
    """Return the number of the step that a coordinate is in; what lies below the range is in its first."""
    return max(int((value - lower) / step), 0)


@njit(cache=True)
def from_steps(steps: int, lower: float, step: float) -> float:
    """Return the coordinate in the middle of a step."""
    return lower + (steps + 0.5) * step


@njit(cache=True)
def cut_into_steps(xy: NDArray[np.float64], step: float, steps: NDArray[np.int64]) -> None:
    """Write the steps of the coordinates of the others, shape (4, 2), to ``steps``, shape (8,): x y x y ..."""
    for k in range(OTHERS):
        steps[2 * k] = to_steps(xy[k, 0], X_LOWER, step)
        steps[2 * k + 1] = to_steps(xy[k, 1], Y_LOWER, step)


@njit(cache=True)
def hash_of_steps(steps: NDArray[np.int64]) -> np.uint64:
    """Return the hash of the cell that eight steps are in: the next cell along a lane is one addition away."""
    mixed = np.uint64(0)
    for k in range(LANES):
        mixed += np.uint64(steps[k] // PARTS) * LANE_HASHES[k]
    return mixed


@njit(cache=True)
def bucket_of_hash(mixed: np.uint64, buckets: int) -> int:
    """Return the bucket in 0 .. buckets - 1, fewer than 2**32, of a hash: its upper bits are well mixed."""
    return int(((mixed >> np.uint64(32)) * np.uint64(buckets)) >> np.uint64(32))


@njit(cache=True)
def pack_parts(steps: NDArray[np.int64]) -> np.uint64:
    """Return where in its cell a key is, three bits a lane, the first lane uppermost."""
    parts = np.uint64(0)
    for k in range(LANES):
        parts = (parts << PART_BITS) | np.uint64(steps[k] % PARTS)
    return parts


@njit(cache=True)
def part_of_lane(parts: np.uint64, lane: int) -> int:
    """Return which of the eight steps of its cell a key is in along a lane."""
    return int((parts >> (PART_BITS * np.uint64(LANES - 1 - lane))) & _PART_MASK)
