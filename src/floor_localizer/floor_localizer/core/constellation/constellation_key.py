"""Geometric hashing: the similarity invariants of six dots, which the index stores and the search looks up.

The two dots farthest apart are the baseline: they are mapped to (0, 0) and (1, 0). The coordinates of the other four,
the inner dots, are then invariant to translation, rotation and scale. Sorted by x, they are the eight numbers of a key.
A key is quantized into cells of an eight-dimensional grid. The cell is hashed to a bucket; the entry also stores the
subcell, which eighth of the cell contains the key along each coordinate.
"""

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Floats, Ints

INNER_DOTS = 4  # number of dots of a constellation other than the two ends of its baseline
KEY_SIZE = 2 * INNER_DOTS

# In the lune, the points closer to both ends of the baseline than its length, x is in 0..1 and y in +-0.866; the rest
# is margin for noise.
X_LOWER, Y_LOWER = -0.1, -1.0
LOWER = (X_LOWER, Y_LOWER)

STEPS_PER_CELL = 8  # quantization steps per cell along each coordinate
STEP_BITS = np.uint64(3)
_STEP_MASK = np.uint64(STEPS_PER_CELL - 1)
_CELL_SIDE_MIN, _CELL_SIDE_MAX = 0.03, 0.3

COORDINATE_HASHES = np.array([
    0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB, 0xD6E8FEB86659FD93,
    0xC2B2AE3D27D4EB4F, 0xFF51AFD7ED558CCD, 0xC4CEB9FE1A85EC53, 0x8EBC6AF09C88C6E3,
], dtype=np.uint64)  # fmt: skip
"""Hash increments from a cell to the next one along each coordinate: odd pseudorandom numbers."""


@njit(cache=True)
def baseline_coordinates(points: Floats, first: int, second: int, inner_dots: Ints, xy: Floats) -> None:
    """Write the coordinates of the inner dots in the frame of a baseline to ``xy``, shape (4, 2) [baseline lengths].

    The baseline is from (0, 0), dot ``first``, to (1, 0), dot ``second``, of ``points``, shape (n, 2) [m].
    """
    ex = points[second, 0] - points[first, 0]
    ey = points[second, 1] - points[first, 1]
    squared = ex * ex + ey * ey
    for k in range(INNER_DOTS):
        dx = points[inner_dots[k], 0] - points[first, 0]
        dy = points[inner_dots[k], 1] - points[first, 1]
        xy[k, 0] = (dx * ex + dy * ey) / squared
        xy[k, 1] = (dy * ex - dx * ey) / squared


@njit(cache=True)
def mean_x_offset(xy: Floats) -> float:
    """Return the offset of the inner dots' mean x from the middle of the baseline [baseline lengths]."""
    return np.sum(xy[:, 0]) / INNER_DOTS - 0.5


@njit(cache=True)
def swap_ends(xy: Floats) -> None:
    """Swap the ends of the baseline in ``xy``, shape (4, 2), in place."""
    for k in range(INNER_DOTS):
        xy[k, 0] = 1.0 - xy[k, 0]
        xy[k, 1] = -xy[k, 1]


@njit(cache=True)
def sort_by_x(xy: Floats) -> None:
    """Sort the inner dots, shape (4, 2), by x, in place."""
    for k in range(1, INNER_DOTS):
        x, y = xy[k, 0], xy[k, 1]
        m = k
        while m > 0 and xy[m - 1, 0] > x:
            xy[m, 0], xy[m, 1] = xy[m - 1, 0], xy[m - 1, 1]
            m -= 1
        xy[m, 0], xy[m, 1] = x, y


def cell_step(keys: int, keys_per_cell: float) -> float:
    """Return the quantization step, an eighth of a cell's side, for a number of keys [baseline lengths].

    Fuller cells (``keys_per_cell``) need fewer reads; emptier cells are so small that noise moves keys out of them. The
    side of an eight-dimensional cell shrinks with the eighth root of the number of keys, so that cells are equally full
    in large and small indices.
    """
    side = min(max((keys_per_cell / max(keys, 1)) ** (1.0 / KEY_SIZE), _CELL_SIDE_MIN), _CELL_SIDE_MAX)
    return side / STEPS_PER_CELL


@njit(cache=True)
def quantize(value: float, lower: float, step: float) -> int:
    """Return the quantization step of a coordinate; values below the range are clipped to step 0."""
    return max(int((value - lower) / step), 0)


@njit(cache=True)
def dequantize(steps: int, lower: float, step: float) -> float:
    """Return the coordinate at the centre of a quantization step."""
    return lower + (steps + 0.5) * step


@njit(cache=True)
def quantize_coordinates(xy: Floats, step: float, steps: Ints) -> None:
    """Write the quantized coordinates of the inner dots, shape (4, 2), to ``steps``, shape (8,): x y x y ..."""
    for k in range(INNER_DOTS):
        steps[2 * k] = quantize(xy[k, 0], X_LOWER, step)
        steps[2 * k + 1] = quantize(xy[k, 1], Y_LOWER, step)


@njit(cache=True)
def hash_cell(steps: Ints) -> np.uint64:
    """Return the hash of the cell of a quantized key: the next cell along a coordinate is one addition away."""
    cell_hash = np.uint64(0)
    for k in range(KEY_SIZE):
        cell_hash += np.uint64(steps[k] // STEPS_PER_CELL) * COORDINATE_HASHES[k]
    return cell_hash


@njit(cache=True)
def bucket_of_hash(cell_hash: np.uint64, buckets: int) -> int:
    """Return the bucket, 0 .. buckets - 1 with buckets < 2**32, of a hash: its upper bits are well mixed."""
    return int(((cell_hash >> np.uint64(32)) * np.uint64(buckets)) >> np.uint64(32))


@njit(cache=True)
def pack_subcell(steps: Ints) -> np.uint64:
    """Return the subcell of a key: three bits per coordinate, the first coordinate uppermost."""
    subcell = np.uint64(0)
    for k in range(KEY_SIZE):
        subcell = (subcell << STEP_BITS) | np.uint64(steps[k] % STEPS_PER_CELL)
    return subcell


@njit(cache=True)
def subcell_step(subcell: np.uint64, coordinate: int) -> int:
    """Return the step of a key within its cell, 0 .. 7, along a coordinate."""
    return int((subcell >> (STEP_BITS * np.uint64(KEY_SIZE - 1 - coordinate))) & _STEP_MASK)
