"""Drives through unknown terrain: sense, remember, plan, go one cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _grid_tasks import GridTask
from numpy.typing import NDArray

from reward_planner.core.planner_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, route_length
from scene_simulator.grid_truth import is_traversable
from scene_simulator.grid_world import GridWorld

SENSOR_RANGE = 6.0
GIVE_UP = 20.0


class Drive(NamedTuple):
    """One drive.

    Attributes:
        ended: 'goal', 'unreachable' (the robot says that there is no way) or 'too long'.
        length: distance driven [cells].
        entered: how many cells it entered.
        entered_late: how many of them in the second half of its steps only.
    """

    ended: str
    length: float
    entered: int
    entered_late: int


Driver = Callable[[NDArray[np.bool_], GridTask, float], Drive]


def drive_optimally(blocked: NDArray[np.bool_], task: GridTask, length_max: float) -> Drive:
    """Follow the shortest route on the map known so far; it is replanned when the robot sees a new obstacle."""
    world, cells, length = GridWorld(blocked), [task.start], 0.0
    routes = DStarLite(np.zeros_like(blocked), task.goal)
    while cells[-1] != task.goal and length <= length_max:
        routes.update_cells(*world.observe(cells[-1], SENSOR_RANGE))
        route = routes.route_from(cells[-1])
        if isinstance(route, NoRoute):
            return _drive('unreachable', blocked, cells)
        cells.append((int(route.cells[1, 0]), int(route.cells[1, 1])))
        length += float(np.hypot(*np.subtract(cells[-1], cells[-2])))
    return _drive('goal' if cells[-1] == task.goal else 'too long', blocked, cells)


def reward_driver(settings: RewardSettings) -> Driver:
    """Return a driver that goes by rewards, and looks first whether the goal can be reached at all."""

    def drive(blocked: NDArray[np.bool_], task: GridTask, length_max: float) -> Drive:
        world, cells, length = GridWorld(blocked), [task.start], 0.0
        walk = RewardWalk(blocked.shape, task.start, task.goal, settings)
        routes = DStarLite(np.zeros_like(blocked), task.goal)
        while not walk.is_at_goal and length <= length_max:
            routes.update_cells(*world.observe(walk.cell, SENSOR_RANGE))
            if isinstance(routes.route_from(walk.cell), NoRoute) or not walk.advance(routes.blocked):
                return _drive('unreachable', blocked, cells)
            cells.append(walk.cell)
            length += float(np.hypot(*np.subtract(cells[-1], cells[-2])))
        return _drive('goal' if walk.is_at_goal else 'too long', blocked, cells)

    return drive


def _drive(ended: str, blocked: NDArray[np.bool_], cells: list[tuple[int, int]]) -> Drive:
    distance = np.array(cells, dtype=np.int64)
    if not is_traversable(blocked, distance):
        raise AssertionError('the robot drove into an obstacle')
    entered, early = (
        len(np.unique(distance, axis=0)),
        len(np.unique(distance[: len(distance) // 2 + 1], axis=0)),
    )
    return Drive(ended, route_length(distance), entered, entered - early)
