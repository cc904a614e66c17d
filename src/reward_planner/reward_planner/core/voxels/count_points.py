"""Counts points into the voxels of a window (2.2.2, step 1), and finds where rays leave it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

_OCCLUDED_FRACTION = 0.8
"""Fraction of near points above which a frame is occluded; a wall close ahead gives fewer."""


class PointCounts(NamedTuple):
    """Number of points of a frame by outcome.

    Attributes:
        counted: points in the window's voxels.
        not_finite: points with a NaN or infinite coordinate.
        too_near: points nearer than range_min.
        too_far: points farther than range_max.
        too_low_or_high: points within range but below or above the voxels.
    """

    counted: int
    not_finite: int
    too_near: int
    too_far: int
    too_low_or_high: int

    @property
    def is_occluded(self) -> bool:
        """Whether nearly all points are too near: the sensor is covered."""
        finite = self.too_near + self.counted + self.too_far + self.too_low_or_high
        return self.too_near >= _OCCLUDED_FRACTION * finite


@njit(cache=True, fastmath={'contract'})
def count_points(
    points: NDArray[np.float32],
    T_window_sensor: NDArray[np.float64],
    ranges: tuple[float, float],
    counts: NDArray[np.int32],
    cells: NDArray[np.int32],
) -> tuple[int, PointCounts]:
    """Count points in voxels; return the number of voxels with points, and of points by outcome.

    Args:
        points: points in the sensor frame [m], shape (n, 3).
        T_window_sensor: transform to voxels from the window's corner, shape (3, 4).
        ranges: least and greatest distance from the sensor [m].
        counts: output, points of each voxel, shape (side, side, layers), all 0 at first.
        cells: output, flat indices of voxels with points, shape (side * side * layers,).
    """
    side, layers = np.int32(counts.shape[1]), np.int32(counts.shape[2])
    flat, top = counts.reshape(-1), float(counts.shape[2])
    (xx, xy, xz, x0), (yx, yy, yz, y0), (zx, zy, zz, z0) = _rows(T_window_sensor)
    near, far = ranges[0] ** 2, ranges[1] ** 2
    filled = counted = invalid_count = near_count = far_count = 0
    for i in range(len(points)):
        x, y, z = float(points[i, 0]), float(points[i, 1]), float(points[i, 2])
        squared = x * x + y * y + z * z
        if not near <= squared <= far:
            if not math.isfinite(squared):
                invalid_count += 1
            elif squared < near:
                near_count += 1
            else:
                far_count += 1
            continue
        height = zx * x + zy * y + zz * z + z0
        if not 0.0 <= height < top:
            continue
        column = np.int32(xx * x + xy * y + xz * z + x0)
        row = np.int32(yx * x + yy * y + yz * z + y0)
        cell = np.uint32(
            (column * side + row) * layers + np.int32(height)
        )  # signed indices cost a check of the sign
        if flat[cell] == 0:
            cells[filled] = cell
            filled += 1
        flat[cell] += 1
        counted += 1
    outside = len(points) - counted - invalid_count - near_count - far_count
    return filled, PointCounts(counted, invalid_count, near_count, far_count, outside)


@njit(cache=True)
def count_ray_exits(
    points: NDArray[np.float32],
    T_window_sensor: NDArray[np.float64],
    ranges: tuple[float, float],
    counts: NDArray[np.int32],
    cells: NDArray[np.int32],
) -> int:
    """Count rays of points outside of the window in their last voxel; return the number of such voxels.

    Rays of points that are too far end at the greatest distance, others at the lower or upper face.

    Args:
        points: points in the sensor frame [m], shape (n, 3).
        T_window_sensor: transform to voxels from the window's corner, shape (3, 4).
        ranges: least and greatest distance from the sensor [m].
        counts: output, ray exits of each voxel, shape (side, side, layers), all 0 at first.
        cells: output, flat indices of voxels with ray exits.
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
        fraction = 1.0 if squared <= far else ranges[1] / math.sqrt(squared)
        height = z0 + fraction * rise
        is_inside = 0.0 <= height < top
        if (is_inside and squared <= far) or (not is_inside and rise == 0.0):
            continue
        if is_inside:
            layer = int(height)
        else:
            border = 0.0 if height < 0.0 else top
            to_border = (border - z0) / rise
            if not 0.0 < to_border <= fraction:
                continue
            fraction, layer = to_border, 0 if height < 0.0 else layers - 1
        column = int(fraction * (xx * x + xy * y + xz * z) + x0)
        row = int(fraction * (yx * x + yy * y + yz * z) + y0)
        cell = np.uint32((column * side + row) * layers + layer)
        if flat[cell] == 0:
            cells[filled] = cell
            filled += 1
        flat[cell] += 1
    return filled


_Row = tuple[float, float, float, float]


@njit(cache=True, inline='always')
def _rows(T: NDArray[np.float64]) -> tuple[_Row, _Row, _Row]:
    """Return the rows of a transform as scalars, which stay in registers."""
    return (
        (T[0, 0], T[0, 1], T[0, 2], T[0, 3]),
        (T[1, 0], T[1, 1], T[1, 2], T[1, 3]),
        (T[2, 0], T[2, 1], T[2, 2], T[2, 3]),
    )
