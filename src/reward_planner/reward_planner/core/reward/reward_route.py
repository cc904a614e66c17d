"""The way that the reward rule takes on a map as it is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.route.octile import route_length
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route
from reward_planner.core.route.shortest_route import shortest_route

_DETOUR_MAX = 20  # the rule gives up after so many times the shortest route


def reward_route(
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    goal: tuple[int, int],
    settings: RewardSettings,
    earlier: NDArray[np.int64] | None = None,
    steps_max: int | None = None,
) -> Route | NoRoute:
    """Return the way by the rule.

    Args:
        blocked: shape (rows, columns), the cells that the robot cannot enter.
        start: row and column.
        goal: row and column.
        settings: of the rule.
        earlier: shape (n, 2), cells where the robot was before, which the rule makes it avoid.
        steps_max: the route ends after so many steps, there or not, and loops are left out, as a robot that is on its
            way sees nothing new in them; None for the whole way to the goal, which may cross itself.
    """
    shortest = shortest_route(blocked, start, goal)
    if isinstance(shortest, NoRoute):
        return shortest
    walk = RewardWalk(blocked.shape, start, goal, settings, earlier)
    thoughts_max = _DETOUR_MAX * min(len(shortest.cells), steps_max or len(shortest.cells))
    cells, steps = [start], 0
    while not walk.is_at_goal and (steps_max is None or len(cells) <= steps_max):
        steps += 1
        if steps > thoughts_max or not walk.advance(blocked):
            return NoRoute(NoRouteReason.GAVE_UP)
        if steps_max is not None and walk.cell in cells:
            del cells[cells.index(walk.cell) :]
        cells.append(walk.cell)
    way = np.array(cells, dtype=np.int64)
    return Route(way, route_length(way))
