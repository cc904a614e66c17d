"""OctoMap by its Python bindings, with its own default sensor model and the range of our settings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.voxel_settings import VoxelSettings

PYOCTOMAP = ('pyoctomap', 'pyoctomap==1.2.2')
"""Module, and what pip installs."""


class OctoMap:
    """A tree that takes frames as they come."""

    def __init__(self, pyoctomap: Any, settings: VoxelSettings) -> None:
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
