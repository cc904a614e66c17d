"""The box of voxels within range of one frame.

Pose and point density of a sensor at the time of a frame.

Point density of clouds without a camera model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import VoxelError
from reward_planner.core.voxels.voxel_settings import VoxelSettings, check_voxel_settings

TILE_SIZE = 16
"""Side of a tile [voxels]."""


_VOXELS_MAX = 2**31 - 1
"""Flat indices of a window have 32 bits."""


class FrameWindow(NamedTuple):
    """A square of whole tiles around the sensor, from the lowest to the highest voxel.

    Cells of the window are flat indices of an array of shape (side, side, layers) along x, y and z.

    Attributes:
        tile_x: index of the first tile along x; tile 0 starts at x = 0 of the map.
        tile_y: index of the first tile along y; tile 0 starts at y = 0 of the map.
        side: number of voxels along x and along y.
        layers: number of voxels along z.
        resolution: side of a voxel [m].
        bottom: height of the lower face of the lowest layer [m].
    """

    tile_x: int
    tile_y: int
    side: int
    layers: int
    resolution: float
    bottom: float

    @property
    def corner(self) -> NDArray[np.float64]:
        """Lowest corner in the map frame [m], shape (3,)."""
        metres = TILE_SIZE * self.resolution
        return np.array([self.tile_x * metres, self.tile_y * metres, self.bottom])

    @property
    def tiles(self) -> int:
        """Number of tiles along x and along y."""
        return self.side // TILE_SIZE


def window_around(view: SensorView, settings: VoxelSettings) -> FrameWindow:
    """Return the window that contains all points within range of a view.

    Raises:
        VoxelError: the view is too far from the map's origin for exact voxels.
    """
    s, reach = settings.resolution, settings.range_max
    first = np.floor((view.origin[:2] - reach) / (TILE_SIZE * s))
    if np.abs(first).max() > 2**31:
        raise VoxelError('the sensor is too far from the origin of the map; check that its pose is in metres')
    side, layers = window_shape(settings)
    return FrameWindow(int(first[0]), int(first[1]), side, layers, s, settings.height_min)


def window_shape(settings: VoxelSettings) -> tuple[int, int]:
    """Return the number of voxels of a window along x and y, and along z.

    Raises:
        VoxelError: contradictory settings, fewer tiles than one frame needs, or too many voxels.
    """
    check_voxel_settings(settings)
    tiles = math.ceil((2.0 * settings.range_max / settings.resolution + 2.0) / TILE_SIZE) + 1
    if settings.tiles_max < tiles**2:
        raise VoxelError(
            f'tiles_max is {settings.tiles_max}, one frame needs {tiles**2}; raise tiles_max or resolution'
        )
    layers = math.ceil((settings.height_max - settings.height_min) / settings.resolution - 1e-6)
    if (TILE_SIZE * tiles) ** 2 * layers > _VOXELS_MAX:
        raise VoxelError(
            f'one frame covers {TILE_SIZE * tiles} x {TILE_SIZE * tiles} x {layers} voxels, more than {_VOXELS_MAX}; '
            'raise resolution or lower range_max'
        )
    return TILE_SIZE * tiles, layers


@njit(cache=True, inline='always')
def unravel_cell(cell: int, side: int, layers: int) -> tuple[int, int, int]:
    """Return column, row and layer of a flat index, as numpy.unravel_index for shape (side, side, layers).

    Multiplying by reciprocals is several times faster than integer division, and exact below 2^40.
    """
    column = int((cell + 0.5) * (1.0 / (side * layers)))
    remainder = cell - column * side * layers
    row = int((remainder + 0.5) * (1.0 / layers))
    return column, row, remainder - row * layers


_ORTHONORMAL_WITHIN = 1e-5


@dataclass(frozen=True)
class SensorView:
    """Pose and point density of a sensor.

    Attributes:
        T_map_sensor: transform from the sensor's optical frame (z forward) to the map frame, shape (4, 4).
        focal_length: points per unit of the tangent of the viewing angle, focal length of a depth image [px]; 0 for
            unknown density.

    Raises:
        VoxelError: not a rigid transform, or a number that is not finite or negative.
    """

    T_map_sensor: NDArray[np.float64]
    focal_length: float

    def __post_init__(self) -> None:
        T = np.asarray(self.T_map_sensor)
        if T.shape != (4, 4) or not np.isfinite(T).all() or (T[3] != (0.0, 0.0, 0.0, 1.0)).any():
            raise VoxelError('T_map_sensor is not a rigid transform; give a 4 x 4 matrix of finite numbers')
        deviation = np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max()
        if deviation > _ORTHONORMAL_WITHIN or np.linalg.det(T[:3, :3]) < 0.0:
            raise VoxelError(
                f'the rotation of T_map_sensor deviates by {deviation:.3g}; give an orthonormal, right-handed one'
            )
        if not (math.isfinite(self.focal_length) and self.focal_length >= 0.0):
            raise VoxelError(f'focal_length is {self.focal_length} px, it must be 0 or more')

    @property
    def origin(self) -> NDArray[np.float64]:
        """Position of the sensor in the map frame [m], shape (3,)."""
        return self.T_map_sensor[:3, 3]


_CELL = 0.05  # bin size of the direction histogram [tangent]
_CELLS = 64  # bins to each side: up to 72 degrees off the axis


def equivalent_focal_length(points: NDArray[np.float32]) -> float:
    """Return the focal length of a depth camera with the same point density, see `SensorView` [px].

    It is the median over the directions with points, so outliers and empty directions have no effect. A sparse lidar
    gets a small value, so that each of its points counts.

    Args:
        points: points in the sensor's optical frame [m], shape (n, 3); those behind it or not finite are ignored.

    Returns:
        focal length [px], 0 without points ahead.
    """
    counts = np.zeros(4 * _CELLS**2, dtype=np.int64)
    _count_directions(points, counts)
    filled = counts[counts > 0]
    return float(np.sqrt(np.median(filled)) / _CELL) if len(filled) else 0.0


@njit(cache=True)
def _count_directions(points: NDArray[np.float32], counts: NDArray[np.int64]) -> None:
    """Count points by direction (tangents), shape (4 _CELLS^2,)."""
    for x, y, z in points:
        if not z > 0.0:
            continue
        column, row = np.floor(x / z / _CELL) + _CELLS, np.floor(y / z / _CELL) + _CELLS
        if 0 <= column < 2 * _CELLS and 0 <= row < 2 * _CELLS:
            counts[int(row) * 2 * _CELLS + int(column)] += 1
