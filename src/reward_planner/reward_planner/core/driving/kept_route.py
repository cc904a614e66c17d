"""Keeps to a route that somebody blocks who may soon go on, rather than take a long way around."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.driving.path_following import free_length
from reward_planner.core.driving.replanner import path_length
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2

WAITS_MAX = 6.0
"""So many times moving_obstacle_wait a robot waits at one place rather than take a long way around."""
_PLACE_SIZE = 0.5  # [m]
# Who walked so near in this time may be who stands in the way now, so near [s, m].
_WALKED_TIME, _WALKED_DISTANCE, _BLOCKED_DISTANCE = 20.0, 3.0, 1.2


class TimeAtPlace:
    """Since when the robot has been at one place."""

    def __init__(self) -> None:
        """Start at no place."""
        self._place, self._since = SE2(math.inf, 0.0, 0.0), math.inf

    def update(self, robot: SE2, now: float) -> float:
        """Take the pose at a time [s]; return for how long the robot has been near it [s]."""
        if not (self._place.distance_to(robot) < _PLACE_SIZE and self._since <= now):
            self._place, self._since = robot, now
        return now - self._since


def route_from(route_map: NDArray[np.float64], robot: SE2) -> NDArray[np.float64]:
    """Return the part of a route, points of shape (n, 2) [m], from the robot on."""
    return route_map[int(np.hypot(*(route_map - (robot.x, robot.y)).T).argmin()) :]


def is_detour_long(detour_map: NDArray[np.float64], route_map: NDArray[np.float64], settings: DrivingSettings) -> bool:
    """Return whether a detour is longer than a route by more than the robot could drive while it waits, and back."""
    worth = 0.5 * settings.moving_obstacle_wait * settings.max_linear_velocity
    return path_length(detour_map) - path_length(route_map) > worth


class KeptRoute:
    """The route that the robot follows, also after planning found a long way around somebody who stands in its way.

    Who stands is in the map. If he walked a moment ago he may be gone before the robot has turned.

    Attributes:
        route_map: points of the route [m], shape (n, 2).
    """

    def __init__(self) -> None:
        """Start without a route."""
        self.reset()

    def reset(self) -> None:
        """Forget the route, for another goal."""
        self.route_map = np.empty((0, 2))
        self._walked, self._waiting, self._time_here = -math.inf, TimeAtPlace(), 0.0

    def is_better(
        self, planned_map: NDArray[np.float64], costmap: InflatedCostmap, now: float, settings: DrivingSettings
    ) -> bool:
        """Return whether to keep the route at a time [s] rather than take the planned one, shape (n, 2) [m]."""
        is_late = self._time_here > WAITS_MAX * settings.moving_obstacle_wait
        if len(self.route_map) == 0 or is_late or now - self._walked > _WALKED_TIME:
            return False
        if free_length(costmap, self.route_map) > _BLOCKED_DISTANCE:
            return False
        return len(planned_map) == 0 or is_detour_long(planned_map, self.route_map, settings)

    def update(
        self, route_map: NDArray[np.float64] | None, robot: SE2, now: float, people: Sequence[tuple[float, float]]
    ) -> None:
        """Take the route at a time [s], shape (n, 2) [m], None while the robot waits, and where people walk [m]."""
        if any(math.dist(each, (robot.x, robot.y)) < _WALKED_DISTANCE for each in people):
            self._walked = now
        self._time_here = self._waiting.update(robot, now)
        if route_map is not None and len(route_map):
            self.route_map = route_map
        elif len(self.route_map):
            self.route_map = route_from(self.route_map, robot)
