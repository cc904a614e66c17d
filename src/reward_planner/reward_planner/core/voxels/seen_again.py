"""Obstacles that a frame should have shown again and did not.

Rays of a sparse sensor pass between voxels, and a near sensor sees only a part of a high obstacle. So beside the rays:

1. Behind test: a voxel of an obstacle is traversed if all rays around it end behind it, and a surface across it would
   have met at least a quarter of a ray.
2. Unseen rest: if rays cleared a part of the column, and nothing of it was hit for ``obstacle_memory``, then what is
   left of it out of view has gone, too. This holds for the connected obstacle as a whole: a table whose top is out of
   view stays when somebody's legs leave from under it. A low box under the view stays when its column above is seen
   free: nothing of it was cleared. Noise at its edge is less than the 0.1 m that must be cleared, and below somebody
   who was there from the first sight there may be a stool, so such a rest stays ten times as long. What is where rays
   passed before has come as a whole: there, one cleared voxel is enough.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from reward_planner.core.voxels.rolling_voxel_grid import (
    NO_TILE,
    TILE_SIZE,
    FrameWindow,
    RollingVoxelGrid,
    SensorView,
    unravel_cell,
)

_RAYS_MAX = 100_000  # denser frames are thinned
_BIN_RAYS = 2.0  # rays across a bin of directions: without ray it is out of view, or has no depth
_BIN_MIN = 0.01  # least width of a bin [tangent]
_TANGENT_MAX = 3.0  # 72 degrees off the axis
_RAYS_EXPECTED = 0.25  # rays that meet a surface across a voxel, at which a missing hit counts
_DEPTH_NOISE = 0.005  # standard deviation of a depth of 1 m; it grows with the square [m]
_CLEARED_MIN, _CLEARED_LAYERS = (0.1, 2)  # height of the cleared part of an obstacle [m, voxels]: more than noise
_CLEARED_FRACTION = 0.3  # of the columns of an obstacle of which a part was cleared
_FIRST_SIGHT_FACTOR = 10.0  # of the memory, for what was there from the first sight
_PASSED, _BLOCKED, _OUT = 0, 1, 2
ENTERED, FIRST_SIGHT = 1, 2


class RayImage(NamedTuple):
    """Least depth of the rays by direction, shape (bins, bins) [m], 0 without ray, and the width of a bin [tangent]."""

    depth: NDArray[np.float32]
    width: float


def ray_image(points: NDArray[np.float32], focal_length: float) -> RayImage:
    """Return the image of points in the optical frame, shape (n, 3) [m], with a density, see `SensorView` [px]."""
    stride = -(-len(points) // _RAYS_MAX) | 1  # odd, so that it visits all columns of an image
    width = max(_BIN_RAYS * math.sqrt(stride) / focal_length, _BIN_MIN)
    bins = 2 * math.ceil(_TANGENT_MAX / width)
    depth = np.zeros((bins, bins), dtype=np.float32)
    _bin_rays(points, stride, width, depth)
    return RayImage(depth, width)


@njit(cache=True)
def _bin_rays(points: NDArray[np.float32], stride: int, width: float, depth: NDArray[np.float32]) -> None:
    bins = len(depth)
    for n in range(0, len(points), stride):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        if not 0.0 < z < np.inf:
            continue
        column, row = x / z / width + 0.5 * bins, y / z / width + 0.5 * bins
        if 0.0 <= column < bins and 0.0 <= row < bins:
            i, j = int(row), int(column)
            if depth[i, j] == 0.0 or z < depth[i, j]:
                depth[i, j] = z


def look_again(
    tiles: RollingVoxelGrid,
    slots: NDArray[np.int64],
    window: FrameWindow,
    points: NDArray[np.float32],
    view: SensorView,
    occupied: float,
) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    """Compare the positive voxels of a window with the rays of a frame; ``occupied`` is an obstacle's least value.

    Returns:
        voxels that rays passed, flat indices, shape (n,); columns whose obstacle is out of view, shape (side, side):
        ENTERED if most of it is where rays passed before, or decays, else FIRST_SIGHT; 0 for others.
    """
    image = ray_image(points, view.focal_length)
    # From voxels of the window to the sensor frame.
    R = view.T_map_sensor[:3, :3].T
    T = np.column_stack([window.resolution * R, R @ (window.corner - view.origin)])
    geometry = window.resolution, view.focal_length, occupied
    return _look_again((tiles.values, tiles.was_free), tiles.has_obstacle, slots, image, T, geometry)


@njit(cache=True)
def _look_again(
    voxels: tuple[NDArray[np.float32], NDArray[np.bool_]],
    has_obstacle: NDArray[np.bool_],
    slots: NDArray[np.int64],
    image: RayImage,
    T: NDArray[np.float64],
    geometry: tuple[float, float, float],
) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    values, was_free = voxels
    side, layers = TILE_SIZE * len(slots), values.shape[3]
    unseen = np.zeros((side, side), dtype=np.int8)
    passed = [np.int32(0) for _ in range(0)]
    for column in range(side):
        for row in range(side):
            slot = slots[column // TILE_SIZE, row // TILE_SIZE]
            if slot == NO_TILE:
                continue
            i, j = column % TILE_SIZE, row % TILE_SIZE
            hidden = come = 0
            for layer in range(layers):
                value = values[slot, i, j, layer]
                if value <= 0.0:
                    continue
                state, expected = _state(image, T, (column + 0.5, row + 0.5, layer + 0.5), geometry)
                if state == _PASSED and expected >= _RAYS_EXPECTED:
                    passed.append(np.int32((column * side + row) * layers + layer))
                if state != _OUT:
                    hidden = -layers  # a part of it is in view
                hidden += 1
                come += was_free[slot, i, j, layer] or value < geometry[2]
            if hidden > 0 and has_obstacle[slot, i, j]:
                unseen[column, row] = ENTERED if 2 * come >= hidden else FIRST_SIGHT
    return np.array(passed, dtype=np.int32), unseen


@njit(cache=True)
def _state(
    image: RayImage, T: NDArray[np.float64], voxel: tuple[float, float, float], geometry: tuple[float, float, float]
) -> tuple[int, float]:
    """Return whether all rays around a voxel pass behind it, and how many rays meet a surface across it."""
    resolution, focal_length, _ = geometry
    x = T[0, 0] * voxel[0] + T[0, 1] * voxel[1] + T[0, 2] * voxel[2] + T[0, 3]
    y = T[1, 0] * voxel[0] + T[1, 1] * voxel[1] + T[1, 2] * voxel[2] + T[1, 3]
    z = T[2, 0] * voxel[0] + T[2, 1] * voxel[1] + T[2, 2] * voxel[2] + T[2, 3]
    half, scale, bins = 0.5 * resolution, 1.0 / (max(z, 1e-6) * image.width), len(image.depth)
    first_row, last_row = (y - half) * scale + 0.5 * bins, (y + half) * scale + 0.5 * bins
    first_column, last_column = (x - half) * scale + 0.5 * bins, (x + half) * scale + 0.5 * bins
    if z <= half or first_row < 0.0 or first_column < 0.0 or last_row >= bins or last_column >= bins:
        return _OUT, 0.0
    total, empty, behind = 0, 0, z + 1.5 * resolution + 2.0 * _DEPTH_NOISE * z * z
    for row in range(int(first_row), int(last_row) + 1):
        for column in range(int(first_column), int(last_column) + 1):
            depth = image.depth[row, column]
            total += 1
            empty += depth == 0.0
            if 0.0 < depth < behind:
                return _BLOCKED, 0.0
    return _OUT if 2 * empty > total else _PASSED, (focal_length * resolution / z) ** 2


@njit(cache=True)
def note_changes(
    tiles: tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.uint8], NDArray[np.float64]],
    slots: NDArray[np.int64],
    window: FrameWindow,
    hits: NDArray[np.int32],
    traversed: NDArray[np.int32],
    change: tuple[float, float, float, float, float],
) -> None:
    """Count the voxels of obstacles that rays clear in each column since its last obstacle; values are added later.

    Args:
        tiles: voxel values, voxels that were free, and of the columns cleared voxels and stamps of the last change [s].
        slots: slots of the window's tiles, shape (tiles, tiles).
        window: window of the frame.
        hits: hit voxels, flat indices, shape (k,).
        traversed: traversed voxels, shape (m,).
        change: stamp of the frame [s], least value of an obstacle, greatest of free space, subtracted and added
            values.
    """
    values, was_free, cleared, changed = tiles
    stamp, occupied, free, amount, hit = change
    for cell in traversed:
        column, row, layer = unravel_cell(cell, window.side, window.layers)
        slot, i, j = slots[column // TILE_SIZE, row // TILE_SIZE], column % TILE_SIZE, row % TILE_SIZE
        value = values[slot, i, j, layer]
        was_free[slot, i, j, layer] |= value <= free
        if value >= occupied > value - amount:
            cleared[slot, i, j] = min(cleared[slot, i, j] + 1, 255)
            changed[slot, i, j] = stamp
    for cell in hits:
        column, row, layer = unravel_cell(cell, window.side, window.layers)
        slot, i, j = slots[column // TILE_SIZE, row // TILE_SIZE], column % TILE_SIZE, row % TILE_SIZE
        changed[slot, i, j] = stamp
        if values[slot, i, j, layer] + hit >= occupied:
            cleared[slot, i, j] = 0  # a single hit, as of somebody who passes, brings no obstacle back


def forget_rest(
    tiles: RollingVoxelGrid,
    slots: NDArray[np.int64],
    window: FrameWindow,
    unseen: NDArray[np.int8],
    traversed: NDArray[np.int32],
    stamp: float,
    memory: float,
) -> None:
    """Drop the unseen rest of obstacles whose seen part was cleared before ``memory`` [s], if rays pass there now."""
    column, row = np.nonzero(unseen)
    place = slots[column // TILE_SIZE, row // TILE_SIZE], column % TILE_SIZE, row % TILE_SIZE
    is_first_sight = unseen[column, row] == FIRST_SIGHT
    kept = np.where(is_first_sight, _FIRST_SIGHT_FACTOR * memory, memory)
    needed = np.where(is_first_sight, max(math.ceil(_CLEARED_MIN / window.resolution - 1e-6), _CLEARED_LAYERS), 1)
    has_left = (tiles.cleared[place] >= needed) & (stamp - tiles.changed[place] >= kept)
    if not has_left.any():
        return
    is_looked_at = np.zeros(window.side**2, dtype=np.bool_)
    is_looked_at[traversed // window.layers] = True
    has_left &= is_looked_at[column * window.side + row]
    labels, count = ndimage.label(unseen > 0, np.ones((3, 3)))
    of_column = labels[column, row]
    columns, left = (np.bincount(each, minlength=count + 1) for each in (of_column, of_column[has_left]))
    gone = (left >= _CLEARED_FRACTION * columns)[of_column]
    place = place[0][gone], place[1][gone], place[2][gone]
    tiles.values[place] = np.minimum(tiles.values[place], 0.0)
