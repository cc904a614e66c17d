"""The box of voxels within range of one frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.sensor_view import SensorView
from reward_planner.core.voxels.voxel_error import VoxelError
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
