"""Planning by the reward rule on the current map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.route.octile import route_length
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route
from reward_planner.core.route.shortest_route import shortest_route

_DETOUR_MAX = 20  # give up after this multiple of the shortest route


def reward_route(
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    goal: tuple[int, int],
    settings: RewardSettings,
    visited_cells: NDArray[np.int64] | None = None,
    steps_max: int | None = None,
) -> Route | NoRoute:
    """Plan a route by the reward rule.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns).
        start: row and column of the start.
        goal: row and column of the goal.
        settings: settings of the reward rule.
        visited_cells: cells that the robot visited before, shape (n, 2); the rule penalises them.
        steps_max: maximum number of steps of the route, from which loops are removed; None for the whole route to the
            goal, which may cross itself.
    """
    shortest = shortest_route(blocked, start, goal)
    if isinstance(shortest, NoRoute):
        return shortest
    walk = RewardWalk(blocked.shape, start, goal, settings, visited_cells)
    total_steps_max = _DETOUR_MAX * min(len(shortest.cells), steps_max or len(shortest.cells))
    cells, steps = [start], 0
    while not walk.is_at_goal and (steps_max is None or len(cells) <= steps_max):
        steps += 1
        if steps > total_steps_max or not walk.advance(blocked):
            return NoRoute(NoRouteReason.GAVE_UP)
        if steps_max is not None and walk.cell in cells:
            del cells[cells.index(walk.cell) :]
        cells.append(walk.cell)
    path = np.array(cells, dtype=np.int64)
    return Route(path, route_length(path))
