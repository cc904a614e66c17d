"""Fast voxel traversal (Amanatides and Woo 1987), one ray for each voxel in which rays end."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.frame_window import unravel_cell

UNSEEN, HIT, TRAVERSED = 0, 1, 2
"""Marks of voxels in a frame. A voxel with points is never marked as traversed."""


@njit(cache=True)
def mark_traversed(
    ends: NDArray[np.int32],
    origin: NDArray[np.float64],
    marks: NDArray[np.uint8],
    traversed: NDArray[np.int32],
    count: int,
) -> int:
    """Mark the voxels between the sensor and the centres of end voxels, without the ends.

    Args:
        ends: flat indices of the end voxels, shape (n,).
        origin: position of the sensor [voxels from the window's corner], shape (3,), inside along x and y.
        marks: marks of voxels, shape (side, side, layers); UNSEEN becomes TRAVERSED.
        traversed: output, flat indices of the marked voxels, from index count on.
        count: number of entries in traversed.

    Returns:
        new number of entries in traversed.
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
