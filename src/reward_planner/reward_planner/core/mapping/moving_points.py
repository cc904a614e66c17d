"""Separates the points of moving obstacles from those that belong into the map."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.driving.moving_obstacle import MovingObstacle
from reward_planner.core.safety.cluster_tracker import ClusterTracker
from reward_planner.core.safety.range_frame import range_frame
from reward_planner.core.safety.range_kernels import CELL, MOVING, STATIC
from reward_planner.core.safety.range_memory import RangeMemory
from reward_planner.core.safety.safety_settings import SourceSettings
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from shirube_core.geometry import SE2

_RANGE_MAX = 5.0  # obstacles are tracked within this range: farther ones have few points [m]
_MEMORY = 10.0  # time for which the tracker keeps what rests [s]
_SPEED_MIN = 0.2  # slower clusters belong into the map [m/s]


class MovingPoints:
    """Tracks clusters that entered space seen free, with the memory and the tracker of the collision monitor.

    Only points of clusters whose velocity is known are kept out of the map: what is neither tracked nor mapped would be
    ignored. Somebody who stands still for 1.5 s is mapped.

    Attributes:
        obstacles: moving obstacles of the latest frame, in the map frame.
    """

    def __init__(self, voxels: VoxelSettings) -> None:
        """Start without obstacles; heights and ranges are those of the voxels."""
        self._source = SourceSettings(
            height_min=voxels.height_min,
            height_max=voxels.height_max,
            range_min=voxels.range_min,
            range_max=min(voxels.range_max, _RANGE_MAX),
        )
        self.reset()

    def reset(self) -> None:
        """Forget all, for instance after the robot's pose jumped."""
        self.obstacles: list[MovingObstacle] = []
        self._memory, self._tracker = RangeMemory(self._source, _MEMORY), ClusterTracker()
        self._stamp = -math.inf

    def static_points(
        self, stamp: float, points: NDArray[np.float32], T_map_sensor: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Update the obstacles with a frame and return its points that do not move, shape (n, 3) [m].

        Args:
            stamp: stamp of the frame [s]; one that is not later than the last changes nothing.
            points: points in the sensor frame, shape (m, 3).
            T_map_sensor: pose of the sensor, shape (4, 4).
        """
        if stamp <= self._stamp:
            return points
        self._stamp = stamp
        R, origin = T_map_sensor[:3, :3], T_map_sensor[:3, 3]
        # 1. Compare the rays with the last seconds: what is where rays passed has moved.
        frame = range_frame(points, np.ones(len(points), dtype=np.bool_), R, origin)
        height, source = frame.ends[:, 2], self._source
        distance = np.hypot(frame.ends[:, 0] - origin[0], frame.ends[:, 1] - origin[1])
        is_used = (source.range_min <= distance) & (distance <= source.range_max)
        is_used &= (source.height_min <= height) & (height <= source.height_max)
        self._memory.update(stamp, frame, SE2(0.0, 0.0, 0.0), is_used)
        cells = self._memory.obstacles()
        # 2. Track its clusters.
        is_now = cells.stamp == stamp
        xy = cells.xy[is_now & (cells.kind == MOVING)]
        motion = self._tracker.update(stamp, xy)
        walks = self._tracker.shifted & np.isfinite(motion.sigma)
        walks &= np.hypot(*motion.velocity.T) >= _SPEED_MIN
        labels = self._tracker.labels
        self.obstacles = [
            _obstacle_of(stamp, xy[labels == k], motion.velocity[labels == k][0])
            for k in np.unique(labels[walks]).tolist()
        ]
        # 3. Their points, and those beside them that do not belong to anything at rest.
        if not walks.any():
            return points
        low = np.floor(cells.xy.min(axis=0) / CELL).astype(np.int64) - 1
        is_moving = np.zeros(np.floor(cells.xy.max(axis=0) / CELL).astype(np.int64) - low + 2, dtype=np.bool_)
        x, y = (np.floor(xy[walks] / CELL).astype(np.int64) - low).T
        for dx, dy in np.ndindex(3, 3):
            is_moving[x + dx - 1, y + dy - 1] = True
        x, y = (np.floor(cells.xy[is_now & (cells.kind == STATIC)] / CELL).astype(np.int64) - low).T
        is_moving[x, y] = False
        rest = points[~_inside(points, T_map_sensor, is_moving, low)]
        # Somebody who fills the view is no covered camera.
        return rest if len(rest) > 0 else points


def _obstacle_of(stamp: float, xy: NDArray[np.float64], velocity: NDArray[np.float64]) -> MovingObstacle:
    """Return the obstacle of a cluster of cells, shape (n, 2) [m]."""
    centre = 0.5 * (xy.min(axis=0) + xy.max(axis=0))
    radius = float(np.hypot(*(xy - centre).T).max()) + 0.5 * math.sqrt(2.0) * CELL
    x, y, speed_x, speed_y = (*centre.tolist(), *velocity.tolist())
    return MovingObstacle(stamp, (x, y), (speed_x, speed_y), radius)


@njit(cache=True)
def _inside(
    points: NDArray[np.float32],
    T: NDArray[np.float64],
    is_moving: NDArray[np.bool_],
    low: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Return which points are in marked cells, whose first is ``low``, shape (n,)."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for n in range(len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        column = math.floor((T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3]) / CELL) - low[0]
        row = math.floor((T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3]) / CELL) - low[1]
        if 0 <= column < is_moving.shape[0] and 0 <= row < is_moving.shape[1]:
            inside[n] = is_moving[column, row]
    return inside
