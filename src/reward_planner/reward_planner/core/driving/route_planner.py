"""Route planners on a changing costmap, one for each planning mode."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drivable_area import DrivableArea
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_route import reward_route
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.incremental_route import IncrementalRoute
from reward_planner.core.route.route import NoRoute, Route


class RoutePlanner(Protocol):
    """Plans routes to one goal on one costmap."""

    def change(self, cells: NDArray[np.int64], blocked: NDArray[np.bool_]) -> None:
        """Set cells, shape (n, 2), blocked or free, shape (n,)."""

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Plan a route from a cell, row and column."""


class RewardPlanner:
    """Plans by the paper's reward rule, which penalises visited cells.

    Args:
        costmap: costmap to plan on; it is read at each call.
        goal: row and column of the goal.
        settings: settings of the reward rule.
        visited_points: earlier positions of the robot [m], shape (n, 2); cells within twice the robot's radius of them
            count as visited.
        radius: robot radius [m].
        steps_max: number of steps per plan.
    """

    def __init__(
        self,
        area: DrivableArea,
        goal: tuple[int, int],
        settings: RewardSettings,
        driven: list[tuple[float, float]],
        radius: float,
        steps_max: int,
    ) -> None:
        self._area, self._goal, self._settings, self._driven = area, goal, settings, driven
        self._radius, self._steps_max = radius, steps_max

    def change(self, cells: NDArray[np.int64], blocked: NDArray[np.bool_]) -> None:
        """Do nothing: the costmap is read at each plan."""

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Plan by the reward rule from a cell, row and column."""
        frame = self._area.frame
        offsets = disc(2.0 * self._radius, frame.resolution)
        places = np.array(self._driven).reshape(-1, 1, 2) + offsets
        earlier = frame.cell_of(places.reshape(-1, 2))
        earlier = earlier[frame.contains(earlier)]
        return reward_route(self._area.blocked, start, self._goal, self._settings, earlier, self._steps_max)


def make_planner(
    area: DrivableArea,
    goal: tuple[int, int],
    planner: PlannerSettings,
    reward: RewardSettings,
    driven: list[tuple[float, float]],
    steps_max: int,
) -> RoutePlanner:
    """Return the planner of the configured mode, see `RewardPlanner`; ``visited_points`` may grow."""
    if planner.mode == 'reward':
        return RewardPlanner(area, goal, reward, driven, planner.robot_radius, steps_max)
    return IncrementalRoute(area.blocked, goal)


def disc(radius: float, resolution: float) -> NDArray[np.float64]:
    """Return the offsets of the cells of a disc, shape (n, 2) [m]."""
    reach = int(radius / resolution)
    steps = resolution * np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return offsets[np.hypot(*offsets.T) <= radius]
