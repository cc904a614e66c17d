"""Points counted into the voxels of a window (2.2.2, step 1), and where rays leave it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

_COVERED_SHARE = 0.8
"""Of the points that are finite; a wall close ahead fills the middle of a wide view, not so much."""


class PointTally(NamedTuple):
    """What became of the points of a frame.

    Attributes:
        counted: lie in the window's voxels.
        not_finite: have a coordinate that is NaN or infinite.
        too_near: are nearer than the range allows.
        too_far: are farther.
        too_low_or_high: are within range, below or above the voxels.
    """

    counted: int
    not_finite: int
    too_near: int
    too_far: int
    too_low_or_high: int

    @property
    def is_blind(self) -> bool:
        """Whether the frame tells nothing of what is ahead: its sensor is covered, or something stands before it."""
        finite = self.too_near + self.counted + self.too_far + self.too_low_or_high
        return self.too_near >= _COVERED_SHARE * finite


@njit(cache=True, fastmath={'contract'})
def count_points(
    points: NDArray[np.float32],
    T_window_sensor: NDArray[np.float64],
    ranges: tuple[float, float],
    counts: NDArray[np.int32],
    cells: NDArray[np.int32],
) -> tuple[int, PointTally]:
    """Count points in voxels; return how many voxels have some, and what became of the points.

    Args:
        points: shape (n, 3), in the sensor frame [m].
        T_window_sensor: shape (3, 4), takes them to voxels from the window's corner.
        ranges: nearest and farthest distance from the sensor [m].
        counts: shape (side, side, layers), all 0; takes the counts.
        cells: shape (side * side * layers,); takes the flat indices of voxels that have points.
    """
    side, layers = np.int32(counts.shape[1]), np.int32(counts.shape[2])
    flat, top = counts.reshape(-1), float(counts.shape[2])
    (xx, xy, xz, x0), (yx, yy, yz, y0), (zx, zy, zz, z0) = _rows(T_window_sensor)
    near, far = ranges[0] ** 2, ranges[1] ** 2
    filled = counted = bad = close = beyond = 0
    for i in range(len(points)):
        x, y, z = float(points[i, 0]), float(points[i, 1]), float(points[i, 2])
        squared = x * x + y * y + z * z
        if not near <= squared <= far:
            if not math.isfinite(squared):
                bad += 1
            elif squared < near:
                close += 1
            else:
                beyond += 1
            continue
        height = zx * x + zy * y + zz * z + z0
        if not 0.0 <= height < top:
            continue
        column = np.int32(xx * x + xy * y + xz * z + x0)
        row = np.int32(yx * x + yy * y + yz * z + y0)
        cell = np.uint32(
            (column * side + row) * layers + np.int32(height)
        )  # signed ones cost a check of the sign
        if flat[cell] == 0:
            cells[filled] = cell
            filled += 1
        flat[cell] += 1
        counted += 1
    outside = len(points) - counted - bad - close - beyond
    return filled, PointTally(counted, bad, close, beyond, outside)


@njit(cache=True)
def count_open_ends(
    points: NDArray[np.float32],
    T_window_sensor: NDArray[np.float64],
    ranges: tuple[float, float],
    counts: NDArray[np.int32],
    cells: NDArray[np.int32],
) -> int:
    """Count, for points outside of the voxels, in which voxel their rays were last; return how many voxels have some.

    Rays of farther points end at the farthest distance, those of lower or higher points at the lower or upper face.

    Args:
        points: as in `count_points`.
        T_window_sensor: as there.
        ranges: as there.
        counts: shape (side, side, layers), all 0; takes the counts.
        cells: takes the flat indices of voxels in which rays end so.
    """
    side, layers = counts.shape[1], counts.shape[2]
    flat, top = counts.reshape(-1), float(layers)
    (xx, xy, xz, x0), (yx, yy, yz, y0), (zx, zy, zz, z0) = _rows(T_window_sensor)
    near, far = ranges[0] ** 2, ranges[1] ** 2
    filled = 0
    for i in range(len(points)):
        x, y, z = float(points[i, 0]), float(points[i, 1]), float(points[i, 2])
        squared = x * x + y * y + z * z
        if not (near <= squared and math.isfinite(squared)):
            continue
        rise = zx * x + zy * y + zz * z
        share = 1.0 if squared <= far else ranges[1] / math.sqrt(squared)
        height = z0 + share * rise
        is_inside = 0.0 <= height < top
        if (is_inside and squared <= far) or (not is_inside and rise == 0.0):
            continue
        if is_inside:
            layer = int(height)
        else:
            border = 0.0 if height < 0.0 else top
            to_border = (border - z0) / rise
            if not 0.0 < to_border <= share:
                continue
            share, layer = to_border, 0 if height < 0.0 else layers - 1
        column = int(share * (xx * x + xy * y + xz * z) + x0)
        row = int(share * (yx * x + yy * y + yz * z) + y0)
        cell = np.uint32((column * side + row) * layers + layer)
        if flat[cell] == 0:
            cells[filled] = cell
            filled += 1
        flat[cell] += 1
    return filled


_Row = tuple[float, float, float, float]


@njit(cache=True, inline='always')
def _rows(T: NDArray[np.float64]) -> tuple[_Row, _Row, _Row]:
    """Return the rows of a transform as numbers, which stay in registers."""
    return (
        (T[0, 0], T[0, 1], T[0, 2], T[0, 3]),
        (T[1, 0], T[1, 1], T[1, 2], T[1, 3]),
        (T[2, 0], T[2, 1], T[2, 2], T[2, 3]),
    )
