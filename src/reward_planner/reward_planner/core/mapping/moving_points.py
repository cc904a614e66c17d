"""Separates the points of moving obstacles from those that belong into the map."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.moving_obstacle import MovingObstacle
from reward_planner.core.safety.cluster_tracker import ClusterTracker
from reward_planner.core.safety.range_frame import range_frame
from reward_planner.core.safety.range_kernels import CELL, MOVING, STATIC
from reward_planner.core.safety.range_memory import RangeMemory
from reward_planner.core.safety.safety_settings import SourceSettings
from reward_planner.core.settings import VoxelSettings
from shirube_core.geometry import SE2

_RANGE_MAX = 5.0  # obstacles are tracked within this range: farther ones have few points [m]
_MEMORY = 10.0  # time for which the tracker keeps what rests [s]
_VIEW_FRACTION = 0.2  # of the points must be left
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
        if not walks.any():
            return points
        # 3. Leave out their points and those beside them, but not what rests there.
        with np.errstate(invalid='ignore'):  # NaN and infinite points
            places = points @ R[:2].T.astype(np.float32) + origin[:2]
        at_rest = cells.xy[is_now & (cells.kind == STATIC)]
        is_kept = ~_find_near(places, xy[walks]) | _find_near(places, at_rest, 0)
        # Somebody who fills the view is mapped: a frame without him would be that of a covered sensor.
        fills_view = (is_kept & np.isfinite(places[:, 0])).sum() < _VIEW_FRACTION * len(points)
        return points if fills_view else points[is_kept]


def _find_near(places: NDArray[np.float64], xy: NDArray[np.float64], reach: int = 1) -> NDArray[np.bool_]:
    """Return which places, shape (n, 2) [m], are within so many cells of the cells at ``xy``, shape (n,)."""
    found = np.zeros(len(places), dtype=np.bool_)
    if len(xy) == 0:
        return found
    low = np.floor(xy.min(axis=0) / CELL) - reach
    marked = np.zeros((np.floor(xy.max(axis=0) / CELL) - low + reach + 1.0).astype(np.int64), dtype=np.uint8)
    marked[tuple((np.floor(xy / CELL) - low).astype(np.int64).T)] = 1
    marked = np.asarray(cv2.dilate(marked, np.ones((2 * reach + 1, 2 * reach + 1))))
    cells = np.floor(places / CELL) - low
    inside = ((cells >= 0.0) & (cells < marked.shape)).all(axis=1)
    found[inside] = marked[tuple(cells[inside].astype(np.int64).T)] > 0
    return found


def _obstacle_of(stamp: float, xy: NDArray[np.float64], velocity: NDArray[np.float64]) -> MovingObstacle:
    """Return the obstacle of a cluster of cells, shape (n, 2) [m]."""
    centre = 0.5 * (xy.min(axis=0) + xy.max(axis=0))
    radius = float(np.hypot(*(xy - centre).T).max()) + 0.5 * math.sqrt(2.0) * CELL
    place, speed = (float(centre[0]), float(centre[1])), (float(velocity[0]), float(velocity[1]))
    return MovingObstacle(stamp, place, speed, radius)
