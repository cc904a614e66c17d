"""OctoMap by its Python bindings, with its own default sensor model and the range of our settings."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.voxel_settings import VoxelSettings

try:
    pyoctomap: Any = import_module('pyoctomap')
except ImportError:
    pyoctomap = None

IS_INSTALLED = pyoctomap is not None
INSTALL = "pyoctomap is not installed; 'pip install pyoctomap==1.2.2' adds OctoMap to the comparison"


class OctoMap:
    """A tree that takes frames as they come."""

    def __init__(self, settings: VoxelSettings) -> None:
        """Begin with nothing known."""
        self._settings = settings
        self._tree = pyoctomap.OcTree(settings.resolution)

    def add(self, points_map: NDArray[np.float32], origin: NDArray[np.float64], *, discretize: bool) -> None:
        """Take the points of a frame, shape (n, 3), and where the sensor was, shape (3,), in the map frame [m]."""
        self._tree.insertPointCloud(
            points_map.astype(np.float64), origin, max_range=self._settings.range_max, discretize=discretize
        )

    def occupied_centres(self) -> NDArray[np.float64]:
        """Return the centres of occupied voxels of the smallest size, shape (n, 3) [m]."""
        centres = []
        smallest = self._settings.resolution
        for leaf in self._tree.begin_leafs():
            if self._tree.isNodeOccupied(leaf):
                size, middle = leaf.getSize(), np.array(leaf.getCoordinate())
                steps = (np.arange(round(size / smallest)) + 0.5) * smallest - 0.5 * size
                centres.append(middle + np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3))
        return np.concatenate(centres) if centres else np.empty((0, 3))


def insert_into_octomap(
    points_map: NDArray[np.float32], origin: NDArray[np.float64], settings: VoxelSettings, discretize: bool
) -> None:
    """Put one frame into a tree that holds it already, as a stationary robot does."""
    key = (id(points_map), discretize)
    if key not in _TREES:
        _TREES[key] = OctoMap(settings)
    _TREES[key].add(points_map, origin, discretize=discretize)


_TREES: dict[tuple[int, bool], OctoMap] = {}
