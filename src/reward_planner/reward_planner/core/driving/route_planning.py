"""Plans the route to a goal outside of the control cycle, on snapshots of the map."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from copy import copy
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.driving.replanner import Replanner
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.route.route import NoRoute
from shirube_core.geometry import SE2

Result = TypeVar('Result')
_NEAR = 2.0  # part of a route in which the robot is [m]


@dataclass(frozen=True)
class PlannedRoute:
    """Result of one planning cycle.

    Attributes:
        points_map: points of the route [m], shape (n, 2), n is 0 if there is none.
        no_route_reason: why there is no route; None if there is one.
        replan_count: number of routes taken so far.
        error: why the goal is invalid, empty if it is not.
    """

    points_map: NDArray[np.float64]
    no_route_reason: NoRoute | None
    replan_count: int
    error: str = ''


RunPlanning = Callable[[Callable[[], PlannedRoute]], Future[PlannedRoute]]
"""Starts a planning cycle, at once or in another thread."""


def run_at_once(work: Callable[[], Result]) -> Future[Result]:
    """Run a planning cycle within the control cycle; results do not depend on the computing time."""
    future: Future[Result] = Future()
    try:
        future.set_result(work())
    except Exception as fault:  # noqa: BLE001 as an executor does
        future.set_exception(fault)
    return future


class RoutePlanning:
    """The route to one goal, as the latest planning cycle found it; at most one cycle runs at a time.

    The `Replanner` is used by planning cycles only. They get what changed together with a snapshot of the map.

    Attributes:
        points_map: remaining route from near the robot to the goal [m], shape (n, 2), n may be 0.
        no_route_reason: why there is no route; None if there is one.
        replan_count: number of routes taken so far.
        error: why the goal is invalid, empty if it is not.
        is_planned: whether a planning cycle was completed.
        is_kept: whether a route is kept, whatever the planning cycles find.
        robot_radius: radius of the robot, or of the greatest circle in its footprint [m].
    """

    def __init__(
        self,
        global_map: GlobalMap,
        make_replanner: Callable[[GlobalMap], Replanner],
        run: RunPlanning,
        previous: RoutePlanning | None = None,
    ) -> None:
        """Start with the route of the previous planning to the same goal, or without one; the map is only read."""
        self._global_map, self._run = global_map, run
        self._map = global_map.snapshot()  # that of the planning cycles
        self._replanner = make_replanner(self._map)
        self.robot_radius = self._replanner.robot_radius
        self._costmap = copy(self._replanner.costmap)  # empty, with the margins of the route
        self.points_map, self.replan_count = np.empty((0, 2)), 0
        if previous is not None:
            self.points_map, self.replan_count = previous.points_map, previous.replan_count
            self._replanner.replan_count = self.replan_count
        self.no_route_reason: NoRoute | None = None
        self.error, self.is_planned, self.is_kept = '', previous is not None, False
        self._changes: list[tuple[GlobalMap, GridFrame | None]] = []
        self._future: Future[PlannedRoute] | None = None
        self._obstacles: LocalMap | None = None
        self._must_compare = False

    def update_map(self, part: GridFrame) -> None:
        """Plan with the changed part of the map from the next cycle on."""
        self._changes.append((self._snapshot(), part))

    def set_obstacles(self, obstacles: LocalMap | None) -> None:
        """Keep the route off temporary obstacles, which are not in the map; they replace the previous ones.

        Without them, the way around them is compared with a new route at once.
        """
        before, self._obstacles = self._obstacles, obstacles
        self._must_compare |= before is not None and obstacles is None
        for each in (before, obstacles):
            if each is not None:
                self.update_map(each.frame)

    def reset(self) -> None:
        """Discard the route and plan it from the whole map again."""
        self._changes = [(self._snapshot(), None)]
        self.points_map, self.no_route_reason, self.is_planned = np.empty((0, 2)), None, False

    def update(self, now: float, robot: SE2) -> None:
        """Take the route of a completed planning cycle, and start the next one at a time [s] from a pose."""
        is_current = self._take_result()
        if self._future is None:
            changes, self._changes = self._changes, []
            must_compare, self._must_compare = self._must_compare, False
            self._future = self._run(lambda: self._plan(changes, now, robot, must_compare))
            is_current = self._take_result()
        if not is_current or self.is_kept or self._future is not None:
            self._drop_passed_points(robot)

    def costmap_around(self, known: GlobalMap, robot: SE2, reach: float) -> InflatedCostmap:
        """Return the costmap of a map within a distance [m] of the robot, with the margins of the route."""
        resolution = known.resolution
        half = int(reach / resolution) + 2
        column, row = (int(np.floor(number / resolution)) - half for number in (robot.x, robot.y))
        side = 2 * half + 1
        costmap = copy(self._costmap)
        frame = GridFrame(column * resolution, row * resolution, resolution, side, side)
        costmap.cover_frame(known, frame)
        return costmap

    def _snapshot(self) -> GlobalMap:
        snapshot = self._global_map.snapshot()
        if self._obstacles is not None:
            snapshot.write(self._obstacles)
        return snapshot

    def _take_result(self) -> bool:
        """Take the result of a completed cycle; return whether there was one."""
        if self._future is None or not self._future.done():
            return False
        future, self._future = self._future, None
        try:
            planned = future.result()
        except Exception:
            self.reset()  # the replanner may have stopped halfway
            raise
        if self.is_kept and len(self.points_map):
            return True
        # A route that was planned before a reset is not taken.
        if not any(part is None for _, part in self._changes):
            self.points_map, self.no_route_reason = planned.points_map, planned.no_route_reason
            self.replan_count, self.error, self.is_planned = planned.replan_count, planned.error, True
        return True

    def _plan(
        self, changes: list[tuple[GlobalMap, GridFrame | None]], now: float, robot: SE2, must_compare: bool
    ) -> PlannedRoute:
        """Plan after changes of the map; in the thread of planning."""
        replanner, error = self._replanner, ''
        for snapshot, part in changes:
            self._map.replace_by(snapshot)
            if part is None:
                replanner.reset()
            else:
                replanner.update_map(part)
        try:
            replanner.update(now, robot, must_compare=must_compare)
        except DrivingError as fault:
            error = str(fault)
        return PlannedRoute(replanner.points_map, replanner.no_route_reason, replanner.replan_count, error)

    def _drop_passed_points(self, robot: SE2) -> None:
        """Drop the points before the nearest one on the next metres of a route that was planned earlier."""
        if len(self.points_map):
            steps = np.hypot(*np.diff(self.points_map, axis=0, prepend=self.points_map[:1]).T)
            near = self.points_map[np.cumsum(steps) <= _NEAR]
            self.points_map = self.points_map[int(np.hypot(*(near - (robot.x, robot.y)).T).argmin()) :]
