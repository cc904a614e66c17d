"""Replans the route when it is blocked, left by the robot or clearly longer than a new one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drivable_area import DrivableArea
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.route_planner import RoutePlanner, make_planner
from reward_planner.core.driving.way_out import way_out
from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.route.reachability import is_reachable
from reward_planner.core.route.route import NoRoute, NoRouteReason, refuse_ends
from shirube_geometry import PlanarPose

_ROUNDING = 1e-5  # clearances are computed in single precision [m]
CELLS_ASIDE = 1.5  # half diagonals of two cells, rounded up [cells]
_OFF_ROUTE = 0.5  # distance from the route at which the robot replans [m]


class RouteKeeper:
    """The current route to one goal.

    Attributes:
        points_map: remaining route from near the robot to the goal [m], shape (n, 2), n may be 0.
        no_route_reason: why there is no route; None if there is one.
        replan_count: number of routes taken so far.
    """

    def __init__(
        self,
        known: GlobalMap,
        goal_map: tuple[float, float],
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
    ) -> None:
        """Start without a route.

        Args:
            global_map: map to plan on; it is only read, call `map_changed` after changes.
            goal_map: x and y of the goal [m].
            planner: planning mode and robot radius.
            reward: settings of the reward rule.
            driving: clearances, lookahead and replanning thresholds.
        """
        self.plans = 0
        self._known, self._goal, self._settings = known, goal_map, driving
        self._modes = (planner, reward)
        self.forget()

    def map_changed(self, part: GridFrame) -> None:
        """Update costmap and planner where the map changed."""
        if self._planner is None:
            return
        cells = self.area.refresh(self._known, part)
        if len(cells):
            self._planner.change(cells, self.area.blocked[cells[:, 0], cells[:, 1]])
            self._has_changed = True

    def forget(self) -> None:
        """Discard route and costmap, for instance after the map was cleared; the goal stays."""
        self.points_map = np.empty((0, 2))
        self.problem: NoRouteReason | None = None
        self.area = self._new_area()
        self._planner: RoutePlanner | None = None
        self._driven: list[tuple[float, float]] = []
        self._has_changed = False
        self._compared_at = -math.inf

    def update(self, now: float, robot: PlanarPose) -> None:
        """Update the route, and replan if needed.

        Args:
            now: current time [s].
            robot: pose of the robot in the map.

        Raises:
            DrivingError: the goal is too far away.
        """
        planner = self._cover(robot)
        self._drop_driven(robot)
        self._note(robot)
        is_late = now - self._compared_at >= self._settings.replan_period or now < self._compared_at
        if len(self.points_map) == 0:
            if is_late or (self._has_changed and self.problem is None):
                self._take(now, robot, planner)
        elif self._is_lost(robot) or self._is_blocked() or self._is_short():
            self._take(now, robot, planner)
        elif self._has_changed and is_late and self._modes[0].mode == 'optimal':
            self._compare(now, robot, planner)

    def _new_area(self) -> DrivableArea:
        radius, driving = self._modes[0].robot_radius, self._settings
        # Distances are between cell centres; the robot and the obstacle's edge are off them.
        keep_away = radius + max(driving.clearance_margin, CELLS_ASIDE * self._known.resolution)
        return DrivableArea(keep_away, max(keep_away, radius + driving.slow_distance) + 0.1)

    def _cover(self, robot: PlanarPose) -> RoutePlanner:
        """Return the planner; a new one if the costmap was resized."""
        changed = self.area.cover(self._known, [self._goal, (robot.x, robot.y)])
        if not changed and self._planner is not None:
            return self._planner
        goal = self.area.frame.cell_of(self._goal)
        self._planner = make_planner(
            self.area, (int(goal[0]), int(goal[1])), *self._modes, self._driven, self._stretch
        )
        self._has_changed = True
        return self._planner

    @property
    def _stretch(self) -> int:
        """Steps along twice the lookahead distance."""
        return 2 + int(2.0 * self._settings.lookahead / self._known.resolution)

    def _take(self, now: float, robot: PlanarPose, planner: RoutePlanner) -> None:
        answer = self._plan(robot, planner)
        self._compared_at, self._has_changed = now, False
        if isinstance(answer, NoRoute):
            self.points_map, self.problem = np.empty((0, 2)), answer.reason
            return
        self.points_map, self.problem = answer, None
        self.plans += 1

    def _compare(self, now: float, robot: PlanarPose, planner: RoutePlanner) -> None:
        """Take a new route if it is shorter by replan_gain and by more than the lookahead distance."""
        answer = self._plan(robot, planner)
        self._compared_at, self._has_changed = now, False
        if isinstance(answer, NoRoute):
            return
        rest = length_of(self.points_map)
        saved = rest - length_of(answer)
        if saved > self._settings.replan_gain * rest and saved > self._settings.lookahead:
            self.points_map = answer
            self.plans += 1

    def _plan(self, robot: PlanarPose, planner: RoutePlanner) -> NDArray[np.float64] | NoRoute:
        """Return the points of a route from the robot; it first leaves the inflated obstacles if it is in them."""
        area = self.area
        ends = area.frame.cell_of([(robot.x, robot.y), self._goal])
        start, goal = ((int(row), int(column)) for row, column in ends)
        refused = refuse_ends(area.blocked, start, goal)
        if refused is not None and refused.reason is not NoRouteReason.START_BLOCKED:
            return refused
        out = way_out(area.clearance, area.blocked, start)
        if out is None:
            return NoRoute(NoRouteReason.START_BLOCKED)
        begin = (int(out[-1, 0]), int(out[-1, 1]))
        if not is_reachable(area.blocked, begin, goal):
            return NoRoute(NoRouteReason.UNREACHABLE)
        answer = planner.route_from(begin)
        if isinstance(answer, NoRoute):
            return answer
        points = area.frame.centre_of(np.concatenate([out[:-1], answer.cells]))
        if (answer.cells[-1] == goal).all():
            points[-1] = self._goal
        return points

    def _drop_driven(self, robot: PlanarPose) -> None:
        """Drop the points before the nearest one within the horizon."""
        if len(self.points_map) == 0:
            return
        distances = np.hypot(*(self.points_map[: self._stretch] - (robot.x, robot.y)).T)
        self.points_map = self.points_map[int(distances.argmin()) :]

    def _note(self, robot: PlanarPose) -> None:
        """Record visited positions, one per robot radius; only the reward rule uses them."""
        planner = self._modes[0]
        if planner.mode != 'reward':
            return
        if not self._driven or math.dist(self._driven[-1], (robot.x, robot.y)) > planner.robot_radius:
            self._driven.append((robot.x, robot.y))

    def _is_short(self) -> bool:
        """Return whether the robot is near the end of a partial route, as the reward rule plans them."""
        ends_before = bool((self.points_map[-1] != self._goal).any())
        return ends_before and length_of(self.points_map) < self._settings.lookahead

    def _is_lost(self, robot: PlanarPose) -> bool:
        return math.hypot(*(self.points_map[0] - (robot.x, robot.y))) > _OFF_ROUTE

    def _is_blocked(self) -> bool:
        """Return whether the route enters blocked cells; where it starts in them, clearance must grow along it."""
        rows, columns = self.area.frame.cell_of(self.points_map).T
        blocked, clearance = self.area.blocked[rows, columns], self.area.clearance[rows, columns]
        enters = blocked[1:] & (~blocked[:-1] | (np.diff(clearance) < -_ROUNDING))
        return bool(enters.any() or blocked[-1])


def length_of(points: NDArray[np.float64]) -> float:
    """Return the length of a path through points of shape (n, 2) [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())
