"""The box of voxels that one frame can reach."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.sensor_view import SensorView
from reward_planner.core.voxels.voxel_error import VoxelError
from reward_planner.core.voxels.voxel_settings import VoxelSettings, refuse_contradictions

TILE = 16
"""Voxels along each side of a tile."""


_VOXELS_MAX = 2**31 - 1
"""Cells of a window are counted in 32 bits."""


class FrameWindow(NamedTuple):
    """A square of whole tiles around the sensor, from the lowest to the highest voxel.

    Cells of the window are flat indices of an array of shape (side, side, layers) along x, y and z.

    Attributes:
        tile_x: index along x of its first tile; tile 0 begins at x = 0 of the map.
        tile_y: the same along y.
        side: voxels along x and y.
        layers: voxels along z.
        resolution: side of a voxel [m].
        bottom: height of the lowest layer's lower face [m].
    """

    tile_x: int
    tile_y: int
    side: int
    layers: int
    resolution: float
    bottom: float

    @property
    def corner(self) -> NDArray[np.float64]:
        """The lowest corner, shape (3,), in the map frame [m]."""
        metres = TILE * self.resolution
        return np.array([self.tile_x * metres, self.tile_y * metres, self.bottom])

    @property
    def tiles(self) -> int:
        """Tiles along x and y."""
        return self.side // TILE


def window_around(view: SensorView, settings: VoxelSettings) -> FrameWindow:
    """Return the window that holds all points within reach of a view.

    Raises:
        VoxelError: the view is too far from the map's origin for exact voxels.
    """
    s, reach = settings.resolution, settings.range_max
    first = np.floor((view.origin[:2] - reach) / (TILE * s))
    if np.abs(first).max() > 2**31:
        raise VoxelError('the sensor is too far from the origin of the map; is its pose in metres?')
    side, layers = window_shape(settings)
    return FrameWindow(int(first[0]), int(first[1]), side, layers, s, settings.height_min)


def window_shape(settings: VoxelSettings) -> tuple[int, int]:
    """Return the voxels along x or y, and along z, of every window.

    Raises:
        VoxelError: settings that contradict each other, fewer tiles than one frame touches, or too many voxels.
    """
    refuse_contradictions(settings)
    tiles = math.ceil((2.0 * settings.range_max / settings.resolution + 2.0) / TILE) + 1
    if settings.tiles_max < tiles**2:
        raise VoxelError(
            f'tiles_max is {settings.tiles_max}, one frame alone reaches {tiles**2}; raise it or resolution'
        )
    layers = math.ceil((settings.height_max - settings.height_min) / settings.resolution - 1e-6)
    if (TILE * tiles) ** 2 * layers > _VOXELS_MAX:
        raise VoxelError(
            f'one frame reaches {TILE * tiles} x {TILE * tiles} x {layers} voxels, more than {_VOXELS_MAX}; '
            'raise resolution or lower range_max'
        )
    return TILE * tiles, layers


@njit(cache=True, inline='always')
def place_of_cell(cell: int, side: int, layers: int) -> tuple[int, int, int]:
    """Return column, row and layer of a flat index in a window of side x side x layers voxels.

    Products with reciprocals are several times as fast as whole divisions, and right as long as cells fit into 2^40.
    """
    column = int((cell + 0.5) * (1.0 / (side * layers)))
    rest = cell - column * side * layers
    row = int((rest + 0.5) * (1.0 / layers))
    return column, row, rest - row * layers
