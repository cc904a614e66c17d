"""A given path in place of planned routes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.replanner import Replanner
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import DrivingSettings, PlannerSettings, RewardSettings
from shirube_core.geometry import SE2


class FixedRoute(Replanner):
    """Keeps to a path: there is no route while it is blocked, and a robot beside it returns to it."""

    def __init__(
        self,
        path_map: NDArray[np.float64],
        global_map: GlobalMap,
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
    ) -> None:
        """Take the points of a path [m], shape (n, 2), and else the arguments of `Replanner`."""
        # A point in every cell, so that every blocked cell of the path is found.
        pieces = [path_map[:1]]
        for begin, end in pairwise(path_map):
            count = int(np.ceil(2.0 * np.hypot(*(end - begin)) / global_map.resolution))
            pieces.append(np.linspace(begin, end, count + 1)[1:])
        self._path = np.concatenate(pieces)
        goal = (float(path_map[-1, 0]), float(path_map[-1, 1]))
        super().__init__(global_map, goal, replace(planner, mode='reward'), reward, driving)
        self._covered = [(float(x), float(y)) for x, y in path_map]

    def _plan(self, robot: SE2) -> NDArray[np.float64] | NoRoute:
        points = self._path[int(np.hypot(*(self._path - (robot.x, robot.y)).T).argmin()) :]
        return NoRoute.UNREACHABLE if self._is_blocked(points) else points
