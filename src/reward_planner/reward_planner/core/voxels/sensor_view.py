"""Where the sensor was when it saw the points of a frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.voxel_error import VoxelError

_ORTHONORMAL_WITHIN = 1e-5


@dataclass(frozen=True)
class SensorView:
    """The pose of a sensor and how dense its points are.

    Attributes:
        T_map_sensor: shape (4, 4), takes points from the sensor's optical frame (z forward) to the map frame.
        focal_length: points per unit of the tangent of the angle of view, for a depth image its focal length [px]; 0
            where the density of the points is not known.

    Raises:
        VoxelError: no rigid pose, or a number that is not finite or negative.
    """

    T_map_sensor: NDArray[np.float64]
    focal_length: float

    def __post_init__(self) -> None:
        T = np.asarray(self.T_map_sensor)
        if T.shape != (4, 4) or not np.isfinite(T).all() or (T[3] != (0.0, 0.0, 0.0, 1.0)).any():
            raise VoxelError('T_map_sensor is no rigid pose; give a 4 x 4 matrix of finite numbers')
        deviation = np.abs(T[:3, :3] @ T[:3, :3].T - np.eye(3)).max()
        if deviation > _ORTHONORMAL_WITHIN or np.linalg.det(T[:3, :3]) < 0.0:
            raise VoxelError(
                f'the rotation of T_map_sensor is off by {deviation:.3g}; give an orthonormal, right-handed one'
            )
        if not (math.isfinite(self.focal_length) and self.focal_length >= 0.0):
            raise VoxelError(f'focal_length is {self.focal_length} px, it must be 0 or more')

    @property
    def origin(self) -> NDArray[np.float64]:
        """Where the sensor is, shape (3,), in the map frame [m]."""
        return self.T_map_sensor[:3, 3]
