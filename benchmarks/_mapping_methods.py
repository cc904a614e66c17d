"""Ways to keep a map over many frames, by what they hold occupied in the end."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.rolling_voxel_grid import NO_TILE, TILE_SIZE, FrameWindow, SensorView, window_shape
from reward_planner.core.voxels.voxel_map import VoxelMap

PYOCTOMAP = ('pyoctomap', 'pyoctomap==1.2.2')  # module, and what pip installs
Dense = NDArray[np.bool_]  # voxels of the room, shape (side, side, layers) along x, y and z
TILES = 12
FIRST_TILE = -6  # the room fills 12 x 12 tiles around the map's origin


class Method(Protocol):
    """Takes frames and says which voxels it holds occupied."""

    def add(self, stamp: float, points: NDArray[np.float32], view: SensorView) -> None:
        """Take a frame."""

    def occupied(self) -> Dense:
        """Return the voxels that it holds occupied."""


def dense_shape(settings: VoxelSettings) -> tuple[int, int, int]:
    """Return the shape of all voxels of the room."""
    return TILES * TILE_SIZE, TILES * TILE_SIZE, window_shape(settings)[1]


class Voxels:
    """One of our rules over time."""

    def __init__(self, settings: VoxelSettings) -> None:
        self._map = VoxelMap(settings)

    def add(self, stamp: float, points: NDArray[np.float32], view: SensorView) -> None:
        """Take a frame."""
        self._map.add(stamp, points, view)

    def occupied(self) -> Dense:
        """Return the voxels whose value is that of an obstacle."""
        settings, tiles = self._map.settings, self._map.tiles
        dense = np.zeros(dense_shape(settings), dtype=np.bool_)
        s, bottom, layers = settings.resolution, settings.height_min, dense.shape[2]
        window = FrameWindow(FIRST_TILE, FIRST_TILE, TILES * TILE_SIZE, layers, s, bottom)
        slots = tiles.slots_of(window)
        for i, j in np.argwhere(slots != NO_TILE).tolist():
            slot = int(slots[i, j])
            if settings.rule == 'log_odds':
                confirmed = tiles.values[slot] >= settings.log_odds_occupied
            else:
                confirmed = tiles.values[slot] >= settings.value_min * np.maximum(tiles.frames[slot], 1.0)
            dense[TILE_SIZE * i : TILE_SIZE * (i + 1), TILE_SIZE * j : TILE_SIZE * (j + 1)] = confirmed
        return dense


class OctoMap:
    """OctoMap by its Python bindings, with its own default sensor model and the range of our settings."""

    def __init__(self, pyoctomap: Any, settings: VoxelSettings) -> None:
        self._settings = settings
        self._tree = pyoctomap.OcTree(settings.resolution)

    def insert(self, points_map: NDArray[np.float32], origin: NDArray[np.float64], *, discretize: bool) -> None:
        """Take the points of a frame, shape (n, 3), and where the sensor was, shape (3,), in the map frame [m]."""
        reach = self._settings.range_max
        points = points_map.astype(np.float64)
        self._tree.insertPointCloud(points, origin, max_range=reach, discretize=discretize)

    def add(self, stamp: float, points: NDArray[np.float32], view: SensorView) -> None:  # noqa: ARG002
        """Take a frame with discretised ends."""
        T = view.T_map_sensor.astype(np.float32)
        self.insert(points @ T[:3, :3].T + T[:3, 3], view.origin, discretize=True)

    def occupied(self) -> Dense:
        """Return the occupied voxels within the heights of the settings."""
        s, bottom = self._settings.resolution, self._settings.height_min
        dense = np.zeros(dense_shape(self._settings), dtype=np.bool_)
        corner = np.array([FIRST_TILE * TILE_SIZE * s, FIRST_TILE * TILE_SIZE * s, bottom])
        cells = np.floor((self._occupied_centres() - corner) / s).astype(np.int64)
        cells = cells[(cells >= 0).all(axis=1) & (cells < dense.shape).all(axis=1)]
        dense[tuple(cells.T)] = True
        return dense

    def _occupied_centres(self) -> NDArray[np.float64]:
        """Return the centres of occupied voxels of the smallest size, shape (n, 3) [m]."""
        centres, smallest = [np.empty((0, 3))], self._settings.resolution
        for leaf in self._tree.begin_leafs():
            if self._tree.isNodeOccupied(leaf):
                size, middle = leaf.getSize(), np.array(leaf.getCoordinate())
                steps = (np.arange(round(size / smallest)) + 0.5) * smallest - 0.5 * size
                centres.append(middle + np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3))
        return np.concatenate(centres)
