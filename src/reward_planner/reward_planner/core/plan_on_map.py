"""Planning on a static map."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from reward_planner.core.grid.inflation import inflate_obstacles
from reward_planner.core.grid.occupancy_map import OccupancyMap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_route import reward_route
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.route import NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route


def plan_on_map(
    grid: OccupancyMap,
    start_map: ArrayLike,
    goal_map: ArrayLike,
    settings: PlannerSettings,
    reward: RewardSettings,
) -> Route | NoRoute:
    """Plan a route between two points; unknown cells are free.

    Args:
        grid: occupancy grid to plan on.
        start_map: start in the map frame [m], shape (2,).
        goal_map: goal in the map frame [m], shape (2,).
        settings: planning mode and robot radius.
        reward: settings of the reward rule, for mode reward.

    Raises:
        RewardPlannerError: a coordinate is not finite.
    """
    blocked = inflate_obstacles(grid.occupied(), grid.frame.resolution, settings.robot_radius)
    ends = grid.frame.cell_of(np.stack([np.asarray(start_map), np.asarray(goal_map)]))
    start, goal = ((int(row), int(column)) for row, column in ends)
    if settings.mode == 'optimal':
        return shortest_route(blocked, start, goal)
    return reward_route(blocked, start, goal, reward)
