"""Route planners on a changing costmap, one for each planning mode."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_route import reward_route
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, Route


class RoutePlanner(Protocol):
    """Plans routes to one goal on one costmap."""

    def update_cells(self, cells: NDArray[np.int64], blocked: NDArray[np.bool_]) -> None:
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
        costmap: InflatedCostmap,
        goal: tuple[int, int],
        settings: RewardSettings,
        visited_points: list[tuple[float, float]],
        radius: float,
        steps_max: int,
    ) -> None:
        self._costmap, self._goal, self._settings, self._visited_points = (
            costmap,
            goal,
            settings,
            visited_points,
        )
        self._radius, self._steps_max = radius, steps_max

    def update_cells(self, cells: NDArray[np.int64], blocked: NDArray[np.bool_]) -> None:
        """Do nothing: the costmap is read at each plan."""

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Plan by the reward rule from a cell, row and column."""
        frame = self._costmap.frame
        offsets = disc_offsets(2.0 * self._radius, frame.resolution)
        points = np.array(self._visited_points).reshape(-1, 1, 2) + offsets
        visited_cells = frame.cell_of(points.reshape(-1, 2))
        visited_cells = visited_cells[frame.contains(visited_cells)]
        return reward_route(
            self._costmap.blocked, start, self._goal, self._settings, visited_cells, self._steps_max
        )


def make_planner(
    costmap: InflatedCostmap,
    goal: tuple[int, int],
    planner: PlannerSettings,
    reward: RewardSettings,
    visited_points: list[tuple[float, float]],
    steps_max: int,
) -> RoutePlanner:
    """Return the planner of the configured mode, see `RewardPlanner`; ``visited_points`` may grow."""
    if planner.mode == 'reward':
        return RewardPlanner(costmap, goal, reward, visited_points, planner.robot_radius, steps_max)
    return DStarLite(costmap.blocked, goal)


def disc_offsets(radius: float, resolution: float) -> NDArray[np.float64]:
    """Return the offsets of the cells of a disc, shape (n, 2) [m]."""
    radius_cells = int(radius / resolution)
    steps = resolution * np.arange(-radius_cells, radius_cells + 1)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return offsets[np.hypot(*offsets.T) <= radius]
