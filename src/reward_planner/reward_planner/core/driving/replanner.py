"""Replans the route when it is blocked, left by the robot or clearly longer than a new one.

Escape path (recovery) of a robot that is too near to an obstacle.

Route planners on a changing costmap, one for each planning mode.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.planner_settings import PlannerSettings, RewardSettings
from reward_planner.core.reward.reward_walk import reward_route
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route, check_endpoints, is_reachable
from shirube_core.geometry import SE2

_ROUNDING = 1e-5  # clearances are computed in single precision [m]
MARGIN_CELLS_MIN = 1.5  # half diagonals of two cells, rounded up [cells]
_OFF_ROUTE_DISTANCE = 0.5  # distance from the route at which the robot replans [m]


class Replanner:
    """The current route to one goal.

    Attributes:
        points_map: remaining route from near the robot to the goal [m], shape (n, 2), n may be 0.
        no_route_reason: why there is no route; None if there is one.
        replan_count: number of routes taken so far.
    """

    def __init__(
        self,
        global_map: GlobalMap,
        goal_map: tuple[float, float],
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
    ) -> None:
        """Start without a route.

        Args:
            global_map: map to plan on; it is only read, call `update_map` after changes.
            goal_map: x and y of the goal [m].
            planner: planning mode and robot radius.
            reward: settings of the reward rule.
            driving: clearances, lookahead and replanning thresholds.
        """
        self.replan_count = 0
        self._global_map, self._goal, self._settings = global_map, goal_map, driving
        self._planning_settings = (planner, reward)
        self.reset()

    def update_map(self, part: GridFrame) -> None:
        """Update costmap and planner where the map changed."""
        if self._planner is None:
            return
        cells = self.costmap.refresh(self._global_map, part)
        if len(cells):
            self._planner.update_cells(cells, self.costmap.blocked[cells[:, 0], cells[:, 1]])
            self._has_changed = True

    def reset(self) -> None:
        """Discard route and costmap, for instance after the map was cleared; the goal stays."""
        self.points_map = np.empty((0, 2))
        self.no_route_reason: NoRouteReason | None = None
        self.costmap = self._make_costmap()
        self._planner: RoutePlanner | None = None
        self._visited: list[tuple[float, float]] = []
        self._has_changed = False
        self._planned_at = -math.inf

    def update(self, now: float, robot: SE2) -> None:
        """Update the route, and replan if needed.

        Args:
            now: current time [s].
            robot: pose of the robot in the map.

        Raises:
            DrivingError: the goal is too far away.
        """
        planner = self._update_planner(robot)
        self._drop_passed_points(robot)
        self._record_position(robot)
        is_due = now - self._planned_at >= self._settings.replan_period or now < self._planned_at
        if len(self.points_map) == 0:
            if is_due or (self._has_changed and self.no_route_reason is None):
                self._replan(now, robot, planner)
        elif self._is_off_route(robot) or self._is_blocked() or self._is_nearly_finished():
            self._replan(now, robot, planner)
        elif self._has_changed and is_due and self._planning_settings[0].mode == 'optimal':
            self._replan_if_shorter(now, robot, planner)

    def _make_costmap(self) -> InflatedCostmap:
        radius, driving = self._planning_settings[0].robot_radius, self._settings
        # Distances are between cell centres; the robot and the obstacle's edge are off them.
        inflation_radius = radius + max(
            driving.clearance_margin, MARGIN_CELLS_MIN * self._global_map.resolution
        )
        return InflatedCostmap(inflation_radius, max(inflation_radius, radius + driving.slow_distance) + 0.1)

    def _update_planner(self, robot: SE2) -> RoutePlanner:
        """Return the planner; a new one if the costmap was resized."""
        changed = self.costmap.cover(self._global_map, [self._goal, (robot.x, robot.y)])
        if not changed and self._planner is not None:
            return self._planner
        goal = self.costmap.frame.cell_of(self._goal)
        self._planner = make_planner(
            self.costmap,
            (int(goal[0]), int(goal[1])),
            *self._planning_settings,
            self._visited,
            self._horizon_steps,
        )
        self._has_changed = True
        return self._planner

    @property
    def _horizon_steps(self) -> int:
        """Steps along twice the lookahead distance."""
        return 2 + int(2.0 * self._settings.lookahead / self._global_map.resolution)

    def _replan(self, now: float, robot: SE2, planner: RoutePlanner) -> None:
        result = self._plan(robot, planner)
        self._planned_at, self._has_changed = now, False
        if isinstance(result, NoRoute):
            self.points_map, self.no_route_reason = np.empty((0, 2)), result.reason
            return
        self.points_map, self.no_route_reason = result, None
        self.replan_count += 1

    def _replan_if_shorter(self, now: float, robot: SE2, planner: RoutePlanner) -> None:
        """Take a new route if it is shorter by replan_gain and by more than the lookahead distance."""
        result = self._plan(robot, planner)
        self._planned_at, self._has_changed = now, False
        if isinstance(result, NoRoute):
            return
        remaining = path_length(self.points_map)
        saved = remaining - path_length(result)
        if saved > self._settings.replan_gain * remaining and saved > self._settings.lookahead:
            self.points_map = result
            self.replan_count += 1

    def _plan(self, robot: SE2, planner: RoutePlanner) -> NDArray[np.float64] | NoRoute:
        """Return the points of a route from the robot; it first leaves the inflated obstacles if it is in them."""
        costmap = self.costmap
        ends = costmap.frame.cell_of([(robot.x, robot.y), self._goal])
        start, goal = ((int(row), int(column)) for row, column in ends)
        failure = check_endpoints(costmap.blocked, start, goal)
        if failure is not None and failure.reason is not NoRouteReason.START_BLOCKED:
            return failure
        escape = escape_path(costmap.clearance, costmap.blocked, start)
        if escape is None:
            return NoRoute(NoRouteReason.START_BLOCKED)
        begin = (int(escape[-1, 0]), int(escape[-1, 1]))
        if not is_reachable(costmap.blocked, begin, goal):
            return NoRoute(NoRouteReason.UNREACHABLE)
        result = planner.route_from(begin)
        if isinstance(result, NoRoute):
            return result
        points = costmap.frame.centre_of(np.concatenate([escape[:-1], result.cells]))
        if (result.cells[-1] == goal).all():
            points[-1] = self._goal
        return points

    def _drop_passed_points(self, robot: SE2) -> None:
        """Drop the points before the nearest one within the horizon."""
        if len(self.points_map) == 0:
            return
        distances = np.hypot(*(self.points_map[: self._horizon_steps] - (robot.x, robot.y)).T)
        self.points_map = self.points_map[int(distances.argmin()) :]

    def _record_position(self, robot: SE2) -> None:
        """Record visited positions, one per robot radius; only the reward rule uses them."""
        planner = self._planning_settings[0]
        if planner.mode != 'reward':
            return
        if not self._visited or math.dist(self._visited[-1], (robot.x, robot.y)) > planner.robot_radius:
            self._visited.append((robot.x, robot.y))

    def _is_nearly_finished(self) -> bool:
        """Return whether the robot is near the end of a partial route, as the reward rule plans them."""
        ends_before = bool((self.points_map[-1] != self._goal).any())
        return ends_before and path_length(self.points_map) < self._settings.lookahead

    def _is_off_route(self, robot: SE2) -> bool:
        return math.hypot(*(self.points_map[0] - (robot.x, robot.y))) > _OFF_ROUTE_DISTANCE

    def _is_blocked(self) -> bool:
        """Return whether the route enters blocked cells; where it starts in them, clearance must grow along it."""
        rows, columns = self.costmap.frame.cell_of(self.points_map).T
        blocked, clearance = self.costmap.blocked[rows, columns], self.costmap.clearance[rows, columns]
        enters = blocked[1:] & (~blocked[:-1] | (np.diff(clearance) < -_ROUNDING))
        return bool(enters.any() or blocked[-1])


def path_length(points: NDArray[np.float64]) -> float:
    """Return the length of a path through points of shape (n, 2) [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


_NEIGHBOURS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)])


def escape_path(
    clearance: NDArray[np.float32], blocked: NDArray[np.bool_], start: tuple[int, int]
) -> NDArray[np.int64] | None:
    """Return the path of steepest clearance ascent from a start to the first free cell.

    Args:
        clearance: distance to the nearest obstacle [m], shape (rows, columns).
        blocked: blocked cells, shape (rows, columns).
        start: row and column of the start, inside of the grid.

    Returns:
        rows and columns, shape (n, 2), only the start if it is free; None if clearance stops growing before.
    """
    cells = [start]
    while blocked[cells[-1]]:
        around = _NEIGHBOURS + cells[-1]
        inside = ((around >= 0) & (around < clearance.shape)).all(axis=1)
        around = around[inside]
        gains = clearance[around[:, 0], around[:, 1]] - clearance[cells[-1]]
        gains /= np.hypot(*(around - cells[-1]).T)
        best = int(gains.argmax())
        if gains[best] <= 0.0:
            return None
        cells.append((int(around[best, 0]), int(around[best, 1])))
    return np.array(cells, dtype=np.int64)


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
