"""Keeps the points of people and other moving obstacles out of the map."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.moving_obstacle_policy import MovingObstacle
from reward_planner.core.safety.cell_classes import PERSON_TIME
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
_SAME_DISTANCE = 0.6  # somebody as near as this to where somebody was before is he [m]
_WAY_MIN = 0.3  # who walked as far may stop and go on; edges that come into view do not [m]
_STANDING_RADIUS, _STANDING_CELLS = 0.5, 3  # where the cells of somebody who stopped are [m], and their least number


class _Walker(NamedTuple):
    """Somebody who walks or walked: the obstacle, where he was seen first [m], and when he walked last [s]."""

    obstacle: MovingObstacle
    origin: tuple[float, float]
    stamp: float


class MovingPoints:
    """Tracks clusters that entered space seen free, with the memory and the tracker of the collision monitor.

    Only points of clusters whose velocity is known are kept out of the map: what is neither tracked nor mapped would be
    ignored. Somebody who walked and stands is expected to go on, so that his place is free as soon as he leaves; after
    `PERSON_TIME` he is mapped.

    Attributes:
        obstacles: moving obstacles of the latest frame, in the map frame; velocity 0 for somebody who stands.
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
        self._walkers: list[_Walker] = []
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
        # 3. Who stopped is where cells came to since.
        came = cells.xy[is_now & (self._memory.arrived() | (cells.kind == MOVING))]
        moving = np.concatenate([xy[walks], came[self._find_standing(stamp, came)]])
        if len(moving) == 0:
            return points
        # 4. Leave out their points and those beside them, but not what rested there before.
        with np.errstate(invalid='ignore'):  # NaN and infinite points
            places = points @ R[:2].T.astype(np.float32) + origin[:2]
        at_rest = cells.xy[is_now & (cells.kind == STATIC) & ~self._memory.arrived()]
        is_kept = ~_find_near(places, moving) | _find_near(places, at_rest, 0)
        # Somebody who fills the view is mapped: a frame without him would be that of a covered sensor.
        fills_view = (is_kept & np.isfinite(places[:, 0])).sum() < _VIEW_FRACTION * len(points)
        return points if fills_view else points[is_kept]

    def _find_standing(self, stamp: float, came: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Add those who walked and stand to the obstacles; return which cells that came, (n, 2) [m], are theirs."""
        before, self._walkers = self._walkers, []
        for each in self.obstacles:
            origins = [one.origin for one in before if _is_same(one.obstacle, each)]
            self._walkers.append(_Walker(each, origins[0] if origins else each.position, stamp))
        stands = np.zeros(len(came), dtype=np.bool_)
        for one in before:
            if stamp - one.stamp > PERSON_TIME or any(_is_same(one.obstacle, each) for each in self.obstacles):
                continue
            here = one.obstacle
            near = np.hypot(*(came - here.position).T) < _STANDING_RADIUS
            if math.dist(here.position, one.origin) > _WAY_MIN and near.sum() >= _STANDING_CELLS:
                stands |= near
                here = _obstacle_of(stamp, came[near], np.zeros(2))
                self.obstacles.append(here)
            self._walkers.append(one._replace(obstacle=here))
        return stands


def _is_same(one: MovingObstacle, other: MovingObstacle) -> bool:
    return math.dist(one.position, other.position) < _SAME_DISTANCE


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
