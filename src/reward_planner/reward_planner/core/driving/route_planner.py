"""Routes in an area that changes, by the planner's mode."""

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
    """Finds routes to one goal in one area."""

    def change(self, cells: NDArray[np.int64], blocked: NDArray[np.bool_]) -> None:
        """Take which cells, shape (n, 2), are blocked now, shape (n,)."""

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Return a route from a cell, row and column."""


class RewardPlanner:
    """Routes by the paper's rule, which remembers where the robot has been.

    Args:
        area: in which routes are sought; it is read whenever a route is asked for.
        goal: row and column.
        settings: of the rule.
        driven: shape (n, 2), where the robot was before [m]; places from which it would stand on the same ground again
            count as visited.
        radius: of the robot [m].
        steps_max: so many steps are decided at a time; what is seen meanwhile counts for the next ones.
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
        """Nothing is kept that changes could touch."""

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Return the way by the rule from a cell, row and column."""
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
    """Return a planner of the mode that is set, see `RewardPlanner`; ``driven`` may grow while the robot drives."""
    if planner.mode == 'reward':
        return RewardPlanner(area, goal, reward, driven, planner.robot_radius, steps_max)
    return IncrementalRoute(area.blocked, goal)


def disc(radius: float, resolution: float) -> NDArray[np.float64]:
    """Return the offsets of cells under a disc, shape (n, 2) [m]."""
    reach = int(radius / resolution)
    steps = resolution * np.arange(-reach, reach + 1)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return offsets[np.hypot(*offsets.T) <= radius]
