"""Decides between driving on, waiting and going around by predicting moving obstacles against the route."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from reward_planner.core.driving.drive_state import DriveState, Velocity
from reward_planner.core.driving.replanner import path_length
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import OCCUPIED, GridFrame
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2


@dataclass(frozen=True)
class MovingObstacle:
    """A tracked cluster of points in the map frame, with constant velocity.

    Attributes:
        stamp: time of the position [s].
        position: centre (x, y) [m].
        velocity: (x, y) [m/s]; (0, 0) for somebody who walked and stands.
        radius: radius of the disc that holds the cluster [m].
    """

    stamp: float
    position: tuple[float, float]
    velocity: tuple[float, float]
    radius: float

    @property
    def is_standing(self) -> bool:
        """Whether it is somebody who walked and stands."""
        return self.velocity == (0.0, 0.0)

    def position_at(self, time: float) -> tuple[float, float]:
        """Return the predicted centre (x, y) at a time [s], in meters."""
        elapsed = time - self.stamp
        return self.position[0] + elapsed * self.velocity[0], self.position[1] + elapsed * self.velocity[1]


_AGE_MAX = 1.0  # an obstacle whose position is older is ignored [s]
_DISTANCE_MAX = 10.0  # an obstacle that is farther away is ignored [m]
_STEP = 0.1  # of the prediction [s]
_CLEARER = 0.02  # where an obstacle is nearer than allowed, it may not come nearer by more than this [m]
_CLEAR_TIME, _DETOUR_TIME = 0.5, 2.0  # times without a conflict that end it, and a way around [s]
_APPROACH_FACTOR = 3.0  # multiple of the prediction time for which a robot that waits must not be reached
_WAITING_SPEED = 0.02  # below this the robot waits [m/s, rad/s]
_PROGRESS = 0.5  # size of a place where the robot waits [m]
_STANDING_RADIUS = 0.2  # of somebody who stands [m]
_WAIT_FORGOTTEN = 30.0  # after this without waiting there, the time at a place starts anew [s]
AROUND_TIME = 2.5
"""A robot that goes around keeps off the path of the obstacle for this time [s]."""
_PATH_MAX = 5.0  # at most for this distance [m]


@dataclass(frozen=True)
class Conflict:
    """A moving obstacle that the robot would meet on its route.

    Attributes:
        obstacle: the obstacle.
        free_distance: length of the route up to the path of the obstacle [m].
        meeting_distance: length of the route up to the predicted meeting [m].
        is_approaching: whether it would also reach a robot that stands.
    """

    obstacle: MovingObstacle
    free_distance: float
    meeting_distance: float
    is_approaching: bool


def predict_conflict(
    route_map: NDArray[np.float64],
    robot: SE2,
    speed: float,
    obstacles: Sequence[MovingObstacle],
    now: float,
    clearance: float,
    settings: DrivingSettings,
) -> Conflict | None:
    """Return the nearest conflict of a robot that accelerates along its route, None if there is none.

    Args:
        route_map: points of the route [m], shape (n, 2).
        robot: pose in the map.
        speed: present speed [m/s].
        obstacles: moving obstacles in the map.
        now: time [s].
        clearance: least distance between the robot's centre and the edge of an obstacle [m].
        settings: limits of the motion, and the time of the prediction.
    """
    if not obstacles or len(route_map) == 0:
        return None
    times = np.arange(0.0, settings.prediction_time + _STEP, _STEP)
    top, acceleration = settings.max_linear_velocity, settings.max_linear_acceleration
    travelled = np.cumsum(np.minimum(top, max(speed, 0.0) + acceleration * times)) * _STEP
    points = np.concatenate([[(robot.x, robot.y)], route_map])
    along = np.cumsum(np.hypot(*np.diff(points, axis=0, prepend=points[:1]).T))
    places = np.stack([np.interp(travelled, along, axis) for axis in points.T], axis=1)
    travelled = np.minimum(travelled, along[-1])
    conflicts = []
    for obstacle in obstacles:
        path = np.array([obstacle.position_at(now + time) for time in times])
        here = float(np.hypot(*(path[0] - points[0])))
        # Who is nearer than allowed may leave.
        reach = min(clearance + obstacle.radius, here - _CLEARER)
        meets = np.hypot(*(path - places).T) < reach
        if not meets.any():
            continue
        crosses = np.hypot(*(path[:, None] - places).transpose(2, 0, 1)).min(axis=0) < reach
        later = np.array([obstacle.position_at(now + _APPROACH_FACTOR * time) for time in times])
        is_approaching = bool((np.hypot(*(later - points[0]).T) < reach).any())
        free, meeting = (float(travelled[max(int(each.argmax()) - 1, 0)]) for each in (crosses, meets))
        conflicts.append(Conflict(obstacle, free, meeting, is_approaching))
    return min(conflicts, key=lambda each: each.meeting_distance, default=None)


class MovingObstaclePolicy:
    """Waits for obstacles that cross the route, for a bounded time, and goes around them or those that approach.

    Attributes:
        state: GIVING_WAY or GOING_AROUND; None without a conflict.
        detail: which obstacle, one line; fixed while the state lasts.
        is_detour_long: whether the robot waits as the way around is long.
        route_map: points of the route with the latest conflict [m], shape (n, 2).
    """

    def __init__(self) -> None:
        """Start without a conflict."""
        self._waited = SE2(math.inf, 0.0, 0.0), math.inf, math.inf  # place, since, and latest time there
        self.reset()

    def reset(self) -> None:
        """Forget all conflicts, for another goal."""
        self.state: DriveState | None = None
        self.detail, self.route_map = '', np.empty((0, 2))
        self._began = self._latest = -math.inf
        self.is_detour_long, self._is_new = False, True

    @property
    def is_around(self) -> bool:
        """Whether the robot goes around."""
        return self.state is DriveState.GOING_AROUND

    def describe(self, velocity: Velocity) -> tuple[DriveState, str]:
        """Return state and detail of a robot with a route and a velocity."""
        if self.state is None:
            return DriveState.DRIVING, DriveState.DRIVING.value
        is_stopped = max(velocity.forward, abs(velocity.turn_rate)) <= _WAITING_SPEED
        state = DriveState.WAITING if is_stopped else self.state
        return state, f'{state.value} {self.detail}'

    def is_waiting_for_route(self, now: float, settings: DrivingSettings) -> bool:
        """Return whether a robot without a route around obstacles should wait for them to leave, at a time [s]."""
        return self.is_around and now - self._began <= settings.moving_obstacle_wait

    def react(
        self,
        route_map: NDArray[np.float64],
        motion: tuple[SE2, float, float],
        obstacles: Sequence[MovingObstacle],
        now: float,
        settings: DrivingSettings,
    ) -> float:
        """Return how far a route is free [m] for a robot of a pose, a speed and a clearance, and update the state."""
        robot, speed, clearance = motion
        self.is_detour_long = self.is_around and self._should_wait(route_map, robot, now, settings)
        if self.is_detour_long:
            route_map = np.empty((0, 2))
        points = route_map if len(route_map) else self.route_map
        standing = [each.position for each in obstacles if each.is_standing]
        if self.is_around and standing and cdist(standing, self.route_map).min() < clearance + _STANDING_RADIUS:
            self._latest = now  # without him, the direct route would lead to him again
        conflict = predict_conflict(points, robot, speed, obstacles, now, clearance, settings)
        return self.update(conflict, route_map, now, settings)

    def _should_wait(self, detour_map: NDArray[np.float64], robot: SE2, now: float, settings: DrivingSettings) -> bool:
        """Return whether waiting is better, for a bounded time, than a long way around, shape (n, 2) [m]."""
        place, since, latest = self._waited
        is_there = place.distance_to(robot) < _PROGRESS and latest <= now < latest + _WAIT_FORGOTTEN
        if self._is_new and not is_there:
            place, since = robot, now
        if self._is_new or is_there:
            self._waited = place, since, now
        self._is_new = False
        if len(detour_map) == 0:
            return False
        nearest = int(np.hypot(*(self.route_map - (robot.x, robot.y)).T).argmin())
        longer = path_length(detour_map) - path_length(self.route_map[nearest:])
        # As long as the way around takes: in hindsight, neither costs more than twice the better one.
        worth = longer / settings.max_linear_velocity
        return worth > max(0.5 * settings.moving_obstacle_wait, now - since)

    def update(
        self, conflict: Conflict | None, route_map: NDArray[np.float64], now: float, settings: DrivingSettings
    ) -> float:
        """Update the state with the conflict on a route; return how far the route is free [m], infinite without one."""
        if conflict is None:
            # A robot that waits drives on as soon as the way is free; one on its way around does not turn back at once.
            is_on_detour = self.is_around and len(route_map) > 0
            if self.state is not None and now - self._latest > (_DETOUR_TIME if is_on_detour else _CLEAR_TIME):
                self.reset()
            return math.inf
        self._latest = now
        is_late = now - self._began > settings.moving_obstacle_wait
        state = self.state
        if len(route_map) and (state is None or (self.is_around and is_late)):
            state, self.route_map = DriveState.GIVING_WAY, route_map
        # An obstacle that comes at the robot would also meet it while it waits.
        if state is DriveState.GIVING_WAY and (conflict.is_approaching or (is_late and state is self.state)):
            state = DriveState.GOING_AROUND
        if state is not self.state:
            x, y = conflict.obstacle.position
            speed = math.hypot(*conflict.obstacle.velocity)
            self.state, self._began = state, now
            self.detail = f'at x {x:.1f} m, y {y:.1f} m, with {speed:.1f} m/s'
        return conflict.meeting_distance if self.is_around else conflict.free_distance


def nearby_obstacles(obstacles: Sequence[MovingObstacle], robot: SE2, now: float) -> list[MovingObstacle]:
    """Return the obstacles near the robot at a time [s] whose position is recent."""
    recent = (each for each in obstacles if abs(now - each.stamp) <= _AGE_MAX)
    return [each for each in recent if math.dist(each.position_at(now), (robot.x, robot.y)) <= _DISTANCE_MAX]


def obstacle_cells(
    obstacles: Sequence[MovingObstacle], now: float, duration: float, resolution: float
) -> LocalMap | None:
    """Return the cells that obstacles cover from a time [s] on for a duration [s], as occupied; None without any."""
    if not obstacles:
        return None
    ends = []
    for each in obstacles:
        later = min(duration, _PATH_MAX / max(math.hypot(*each.velocity), 1e-3))
        ends.append((each.position_at(now), each.position_at(now + later)))
    cells = np.floor(np.array(ends) / resolution).astype(np.int64)
    widths = [1 + math.ceil(2.0 * each.radius / resolution) for each in obstacles]
    low = cells.min(axis=(0, 1)) - max(widths)
    columns, rows = (int(n) for n in cells.max(axis=(0, 1)) + max(widths) + 1 - low)
    covered = np.zeros((rows, columns), dtype=np.uint8)
    for (begin, end), width in zip((cells - low).tolist(), widths, strict=True):
        cv2.line(covered, begin, end, 1, width)  # a capsule: its ends are round
    frame = GridFrame(float(low[0] * resolution), float(low[1] * resolution), resolution, columns, rows)
    return LocalMap(frame, np.full(frame.shape, OCCUPIED, dtype=np.int8), covered > 0)


def with_obstacles(global_map: GlobalMap, obstacles: Sequence[MovingObstacle], now: float) -> GlobalMap:
    """Return the map with the obstacles where they are at a time [s]; the map itself if there are none."""
    cells = obstacle_cells(obstacles, now, 0.0, global_map.resolution)
    if cells is None:
        return global_map
    snapshot = global_map.snapshot()
    snapshot.write(cells)
    return snapshot
