"""Updates the local and the global map from points and the robot's pose (2.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.mapping.local_map import LocalMap
from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.projection import project_voxels
from reward_planner.core.voxels.count_points import PointCounts
from reward_planner.core.voxels.sensor_view import SensorView
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from shirube_core.geometry import SE2, CameraMount


class ObstacleMapper:
    """Maps the obstacles that one sensor sees.

    Attributes:
        voxels: voxel map around the robot.
        map: global map.
    """

    def __init__(self, mount: CameraMount, voxels: VoxelSettings, mapping: MappingSettings) -> None:
        """Start with empty maps.

        Args:
            mount: pose of the sensor's optical frame in the base frame.
            voxels: settings of the voxel map.
            mapping: maximum size of the global map.

        Raises:
            VoxelError: the settings give no voxels.
        """
        self._T_base_sensor = _matrix_from_parts(mount.rotation, np.array(mount.xyz))
        self.voxels = VoxelMap(voxels)
        self.map = GlobalMap(voxels.resolution, mapping.cells_max)

    def add(
        self, stamp: float, points: ArrayLike, T_map_base: SE2, focal_length: float
    ) -> tuple[LocalMap, PointCounts]:
        """Add a frame; return the local map and the number of points by outcome.

        Args:
            stamp: stamp of the frame [s].
            points: points in the sensor's optical frame [m], array-like, shape (n, 3).
            T_map_base: pose of the robot at the stamp.
            focal_length: density of the points, see `SensorView`.

        Raises:
            VoxelError: points of a wrong shape, or a pose or stamp that is not finite.
        """
        view = SensorView(_matrix_from_pose(T_map_base) @ self._T_base_sensor, focal_length)
        point_counts = self.voxels.add(stamp, points, view).point_counts
        local = project_voxels(self.voxels, view, self.map)
        self.map.write(local)
        return local, point_counts

    def clear(self) -> None:
        """Clear both maps."""
        self.voxels.clear()
        self.map.clear()


def _matrix_from_pose(pose: SE2) -> NDArray[np.float64]:
    cos, sin = np.cos(pose.yaw), np.sin(pose.yaw)
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return _matrix_from_parts(rotation, np.array([pose.x, pose.y, 0.0]))


def _matrix_from_parts(
    rotation: NDArray[np.float64], translation: NDArray[np.float64]
) -> NDArray[np.float64]:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, translation
    return T
