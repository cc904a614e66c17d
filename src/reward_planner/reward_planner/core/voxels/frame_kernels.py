"""Numba kernels of one frame: points counted in the voxels of a window (2.2.2, step 1), and rays traced through them.

The rays follow Amanatides and Woo 1987, one ray for each voxel in which rays of points end.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.rolling_voxel_grid import unravel_cell

UNSEEN, HIT, TRAVERSED = 0, 1, 2
"""Marks of voxels in a frame. A voxel with points is never marked as traversed."""

_OCCLUDED_FRACTION = 0.8  # of the points are near: a covered sensor; a wall close ahead gives fewer
_Row = tuple[float, float, float, float]


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
    def near_fraction(self) -> float:
        """Fraction of the finite points that are too near; 0 without any."""
        finite = self.too_near + self.counted + self.too_far + self.too_low_or_high
        return self.too_near / max(finite, 1)

    @property
    def is_occluded(self) -> bool:
        """Whether nearly all points are too near, or none is finite: the sensor is covered."""
        return self.near_fraction >= _OCCLUDED_FRACTION or self.not_finite == sum(self)


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
        # Signed indices would cost a check of the sign.
        cell = np.uint32((column * side + row) * layers + np.int32(height))
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

    Rays of points that are too far end at the greatest distance, others at the lower or upper face. Arguments as for
    `count_points`; the outputs are ray exits instead of points.
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


@njit(cache=True, inline='always')
def _rows(T: NDArray[np.float64]) -> tuple[_Row, _Row, _Row]:
    """Return the rows of a transform as scalars, which stay in registers."""
    return (
        (T[0, 0], T[0, 1], T[0, 2], T[0, 3]),
        (T[1, 0], T[1, 1], T[1, 2], T[1, 3]),
        (T[2, 0], T[2, 1], T[2, 2], T[2, 3]),
    )


@njit(cache=True)
def mark_traversed(
    ends: NDArray[np.int32],
    origin: NDArray[np.float64],
    marks: NDArray[np.uint8],
    traversed: NDArray[np.int32],
    count: int,
) -> int:
    """Mark the voxels between the sensor and the centres of end voxels (flat indices), without the ends.

    The origin is the sensor's position [voxels from the window's corner], inside along x and y. Marks have the shape
    (side, side, layers); UNSEEN becomes TRAVERSED. Flat indices of marked voxels are appended to ``traversed`` from
    index ``count`` on; return the new count.
    """
    side, layers = marks.shape[1], marks.shape[2]
    flat = marks.reshape(-1)
    for end in ends:
        count = _traverse_ray(flat, (side, layers), origin, unravel_cell(end, side, layers), traversed, count)
    return count


@njit(cache=True)
def mark_traversed_exits(
    ends: NDArray[np.int32], marks: NDArray[np.uint8], traversed: NDArray[np.int32], count: int
) -> int:
    """Mark the end voxels of rays that leave the window; arguments as for `mark_traversed`."""
    flat = marks.reshape(-1)
    for end in ends:
        if flat[end] == UNSEEN:
            flat[end] = TRAVERSED
            traversed[count] = end
            count += 1
    return count


@njit(cache=True, inline='always')
def _axis(start: float, end: float, cell: int, last: int) -> tuple[int, int, float, float]:
    """Return number and sign of steps, and the ray parameter at the first border and between borders."""
    steps = abs(last - cell)
    sign = 1 if last > cell else -1
    if steps == 0:
        return 0, sign, math.inf, math.inf
    between = 1.0 / abs(end - start)
    border = float(cell + 1) if sign > 0 else float(cell)
    return steps, sign, abs(border - start) * between, between


@njit(cache=True)
def _traverse_ray(
    flat: NDArray[np.uint8],
    shape: tuple[int, int],
    origin: NDArray[np.float64],
    last: tuple[int, int, int],
    traversed: NDArray[np.int32],
    count: int,
) -> int:
    """Mark the voxels along one ray."""
    side, layers = shape
    x, y, z = origin[0], origin[1], origin[2]
    end_x, end_y, end_z = last[0] + 0.5, last[1] + 0.5, last[2] + 0.5
    if z < 0.0 or z >= layers:
        border = 0.0 if z < 0.0 else float(layers)
        fraction = (border - z) / (end_z - z)
        x, y, z = x + fraction * (end_x - x), y + fraction * (end_y - y), border
    column, row = int(x), int(y)
    layer = min(int(z), layers - 1)
    steps_x, sign_x, at_x, between_x = _axis(x, end_x, column, last[0])
    steps_y, sign_y, at_y, between_y = _axis(y, end_y, row, last[1])
    steps_z, sign_z, at_z, between_z = _axis(z, end_z, layer, last[2])
    cell = (column * side + row) * layers + layer
    stride_x, stride_y = sign_x * side * layers, sign_y * layers
    for _ in range(steps_x + steps_y + steps_z):
        here = np.uint64(cell)  # signed indices cost a check of the sign
        if flat[here] == UNSEEN:
            flat[here] = TRAVERSED
            traversed[count] = cell
            count += 1
        if at_x < at_y and at_x < at_z:
            cell += stride_x
            steps_x -= 1
            at_x = at_x + between_x if steps_x > 0 else math.inf
        elif at_y < at_z:
            cell += stride_y
            steps_y -= 1
            at_y = at_y + between_y if steps_y > 0 else math.inf
        else:
            cell += sign_z
            steps_z -= 1
            at_z = at_z + between_z if steps_z > 0 else math.inf
    return count
