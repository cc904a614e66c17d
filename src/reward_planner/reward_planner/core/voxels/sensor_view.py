"""Pose and point density of a sensor at the time of a frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.voxel_error import VoxelError

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
