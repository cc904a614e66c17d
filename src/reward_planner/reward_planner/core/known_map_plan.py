"""A route on a map that is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.grid.footprint import blocked_cells
from reward_planner.core.grid.occupancy_map import OccupancyMap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.route.octile import route_length
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route
from reward_planner.core.route.shortest_route import shortest_route

_DETOUR_MAX = 20  # the reward rule gives up after so many times the shortest route


def plan_on_map(
    grid: OccupancyMap,
    start_map: ArrayLike,
    goal_map: ArrayLike,
    settings: PlannerSettings,
    reward: RewardSettings,
) -> Route | NoRoute:
    """Return a route between two points; what is unknown is taken for free.

    Args:
        grid: the map.
        start_map: shape (2,), x and y in the map frame [m].
        goal_map: shape (2,), likewise.
        settings: of the planner.
        reward: of the reward rule, for mode reward.

    Raises:
        RewardPlannerError: a coordinate is not finite.
    """
    blocked = blocked_cells(grid.occupied(), grid.frame.resolution, settings.robot_radius)
    ends = grid.frame.cell_of(np.stack([np.asarray(start_map), np.asarray(goal_map)]))
    start, goal = ((int(row), int(column)) for row, column in ends)
    shortest = shortest_route(blocked, start, goal)
    if settings.mode == 'optimal' or isinstance(shortest, NoRoute):
        return shortest
    return _walk(blocked, start, goal, reward, _DETOUR_MAX * len(shortest.cells))


def _walk(
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    goal: tuple[int, int],
    reward: RewardSettings,
    steps_max: int,
) -> Route | NoRoute:
    walk = RewardWalk(blocked.shape, start, goal, reward)
    cells = [start]
    while not walk.is_at_goal:
        if len(cells) > steps_max or not walk.advance(blocked):
            return NoRoute(NoRouteReason.GAVE_UP)
        cells.append(walk.cell)
    way = np.array(cells, dtype=np.int64)
    return Route(way, route_length(way))
