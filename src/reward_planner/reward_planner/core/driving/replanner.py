"""Replans the route when it is blocked, left by the robot or clearly costlier than a new one."""

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.inflated_costmap import FootprintCheck, InflatedCostmap
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.reward.reward_walk import reward_route
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import (
    COST_MAX,
    HIDDEN_FACTOR,
    LETHAL,
    NoRoute,
    Route,
    check_endpoints,
    is_reachable,
    travel_costs,
)
from reward_planner.core.safety.footprint import Footprint
from reward_planner.core.settings import DrivingSettings, PlannerSettings, RewardSettings
from shirube_core.geometry import SE2, wrap_angle

MARGIN_CELLS_MIN = 1.5  # half diagonals of two cells, rounded up [cells]
_ROUNDING = 1e-5  # clearances are computed in single precision [m]
_OFF_ROUTE_DISTANCE = 0.5  # distance from the route at which the robot replans [m]
_TURN_DISTANCE = 0.3  # a route's direction is that of its first point beyond this distance [m]
_SEARCHES_MAX = 20  # searches for a route that the footprint can follow
_NEIGHBOURS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)])


class Replanner:
    """The current route to one goal.

    Attributes:
        costmap: inflated obstacles around robot, goal and known cells.
        points_map: remaining route from near the robot to the goal [m], shape (n, 2), n may be 0.
        no_route_reason: why there is no route; None if there is one.
        replan_count: number of routes taken so far.
        robot_radius: radius of the robot, or of the greatest circle in its footprint [m].
    """

    def __init__(
        self,
        global_map: GlobalMap,
        goal_map: tuple[float, float],
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
        *,
        whole_route: bool = False,
    ) -> None:
        """Start without a route to a goal (x, y) [m]; the map is only read, call `update_map` after changes.

        The reward rule plans some steps ahead as the map becomes known, or, with ``whole_route``, all steps.
        """
        self.replan_count = 0
        self._global_map, self._goal, self._settings = global_map, goal_map, driving
        self._planner, self._reward = planner, reward
        footprint = Footprint(planner.footprint, planner.robot_radius)
        self.robot_radius = footprint.inscribed_radius if planner.footprint else planner.robot_radius
        resolution = global_map.resolution
        self._footprint = FootprintCheck(footprint, resolution) if planner.footprint else None
        self._covered = [goal_map]  # by the costmap, with the robot
        horizon = 2 + int(2.0 * driving.lookahead / resolution)
        self._horizon_steps = None if whole_route else horizon
        self.reset()

    def reset(self) -> None:
        """Discard route and costmap, for instance after the map was cleared; the goal stays."""
        radius, driving, planner = self.robot_radius, self._settings, self._planner
        # Distances are between cell centres; the robot and the obstacle's edge are off them.
        margin = max(driving.clearance_margin, MARGIN_CELLS_MIN * self._global_map.resolution)
        clearance_max = max(radius + margin, radius + driving.slow_distance)
        if planner.cost_scaling_factor > 0.0:
            clearance_max = max(clearance_max, planner.inflation_radius)
        if self._footprint is not None:
            clearance_max = max(clearance_max, self._footprint.clearance_min)
        self.costmap = InflatedCostmap(radius + margin, clearance_max + 0.1, planner)
        self.points_map = np.empty((0, 2))
        self.no_route_reason: NoRoute | None = None
        self._search: DStarLite | None = None
        self._visited: list[tuple[float, float]] = []
        self._has_costmap = self._has_changed = False
        self._planned_at = -math.inf

    def update_map(self, part: GridFrame) -> None:
        """Update costmap and search where the map changed."""
        if not self._has_costmap:
            return
        cells = self.costmap.refresh(self._global_map, part)
        if len(cells):
            if self._search is not None:
                self._search.update_cells(cells, travel_costs(self.costmap.costs[cells[:, 0], cells[:, 1]]))
            self._has_changed = True

    def update(self, now: float, robot: SE2, *, must_compare: bool = False) -> None:
        """Update the route at a time [s] for a pose of the robot in the map, and replan if needed.

        A free route is compared with a new one once per period, or now if it must.

        Raises:
            DrivingError: the goal is too far away.
        """
        # A resized costmap needs a new search.
        if self.costmap.cover(self._global_map, [*self._covered, (robot.x, robot.y)]) or not self._has_costmap:
            if self._planner.mode == 'optimal':
                multiplier = HIDDEN_FACTOR * self._planner.cost_travel_multiplier
                self._search = DStarLite(travel_costs(self.costmap.costs), self._cell_of(self._goal), multiplier)
            self._has_costmap = self._has_changed = True
        # The robot moved: the route begins at its nearest point, and the reward rule remembers the place.
        self._drop_passed_points(robot)
        self._record_position(robot)
        is_due = must_compare or now - self._planned_at >= self._settings.replan_period or now < self._planned_at
        # Without a route: plan at once on a changed map, and then once per period.
        if len(self.points_map) == 0:
            if is_due or (self._has_changed and self.no_route_reason is None):
                self._replan(now, robot)
        # A route that cannot be followed to its end is replaced at once.
        elif self._is_off_route(robot) or self._is_blocked(self.points_map) or self._is_nearly_finished():
            self._replan(now, robot)
        elif self._has_changed and self._search is not None:
            if self._collides(self.points_map).any():
                self._replan(now, robot)
            # A free route is replaced once per period, if the map changed and the new one costs clearly less.
            elif is_due:
                self._replan(now, robot, only_if_better=True)

    def _replan(self, now: float, robot: SE2, *, only_if_better: bool = False) -> None:
        result = self._plan(robot)
        self._planned_at, self._has_changed = now, False
        if isinstance(result, NoRoute):
            if not only_if_better:
                self.points_map, self.no_route_reason = np.empty((0, 2)), result
        elif not only_if_better or self._is_clearly_better(result, robot):
            self.points_map, self.no_route_reason = result, None
            self.replan_count += 1

    def _plan(self, robot: SE2) -> NDArray[np.float64] | NoRoute:
        """Return the points of a route from the robot; it first leaves the inflated obstacles if it is in them."""
        costmap = self.costmap
        start, goal = self._cell_of((robot.x, robot.y)), self._cell_of(self._goal)
        failure = check_endpoints(costmap.blocked, start, goal)
        if failure is not None and failure is not NoRoute.START_BLOCKED:
            return failure
        escape = escape_path(costmap.clearance, costmap.blocked, start)
        if escape is None:
            return NoRoute.START_BLOCKED
        begin = (int(escape[-1, 0]), int(escape[-1, 1]))
        if not is_reachable(costmap.blocked, begin, goal):
            return NoRoute.UNREACHABLE
        if self._search is not None:
            result = self._feasible_route(self._search, begin)
        else:
            result = reward_route(
                costmap.blocked, begin, goal, self._reward, self._visited_cells(), self._horizon_steps
            )
        if isinstance(result, NoRoute):
            return result
        points = costmap.frame.centre_of(np.concatenate([escape[:-1], result.cells]))
        if (result.cells[-1] == goal).all():
            points[-1] = self._goal
        return points

    def _feasible_route(self, search: DStarLite, begin: tuple[int, int]) -> Route | NoRoute:
        """Return a route of least cost; with a footprint, one that it can follow in the direction of the route.

        Cells where the footprint collides are blocked, and the search is repeated. Of the last search all cells are
        blocked that are not free in every direction.
        """
        costmap, result = self.costmap, search.route_from(begin)
        if self._footprint is None:
            return result
        ends, avoided = np.array([begin, self._cell_of(self._goal)]), [np.empty((0, 2), dtype=np.int64)]
        for count in range(_SEARCHES_MAX):
            cells = self._colliding_cells(result)
            if len(cells) == 0:
                break
            if count == _SEARCHES_MAX - 1:
                cells = np.argwhere(costmap.clearance <= self._footprint.clearance_min)
            avoided.append(cells[(cells[:, None] != ends).any(axis=2).all(axis=1)])
            search.update_cells(avoided[-1], LETHAL)
            result = search.route_from(begin)
        rows, columns = np.concatenate(avoided).T
        search.update_cells(np.stack([rows, columns], axis=1), travel_costs(costmap.costs[rows, columns]))
        return NoRoute.UNREACHABLE if len(self._colliding_cells(result)) else result

    def _colliding_cells(self, route: Route | NoRoute) -> NDArray[np.int64]:
        """Return the cells of a route where the footprint collides, shape (n, 2)."""
        if isinstance(route, NoRoute):
            return np.empty((0, 2), dtype=np.int64)
        collides = self._collides(self.costmap.frame.centre_of(route.cells))
        # At the goal the direction is that of the last steps: the cell before it is to blame.
        collides[-2:-1] |= collides[-1:]
        return route.cells[collides]

    def _collides(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return at which points of a route but the first the footprint collides, shape (n,)."""
        if self._footprint is None:
            return np.zeros(len(points), dtype=np.bool_)
        collides = self._footprint.collides(points, self.costmap)
        collides[:1] = False  # the robot is there
        return collides

    def _cell_of(self, point_map: tuple[float, float]) -> tuple[int, int]:
        row, column = self.costmap.frame.cell_of(point_map)
        return int(row), int(column)

    def _drop_passed_points(self, robot: SE2) -> None:
        """Drop the points before the nearest one within the horizon."""
        if len(self.points_map):
            distances = np.hypot(*(self.points_map[: self._horizon_steps] - (robot.x, robot.y)).T)
            self.points_map = self.points_map[int(distances.argmin()) :]

    def _record_position(self, robot: SE2) -> None:
        """Record visited positions, one per robot radius; only the reward rule uses them."""
        here = (robot.x, robot.y)
        if self._search is None and (not self._visited or math.dist(self._visited[-1], here) > self.robot_radius):
            self._visited.append(here)

    def _visited_cells(self) -> NDArray[np.int64]:
        """Return the cells within twice the robot's radius of visited positions, shape (n, 2)."""
        frame, radius = self.costmap.frame, 2.0 * self.robot_radius
        cells = int(radius / frame.resolution)
        steps = frame.resolution * np.arange(-cells, cells + 1)
        offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        disc = offsets[np.hypot(*offsets.T) <= radius]
        visited = frame.cell_of((np.array(self._visited).reshape(-1, 1, 2) + disc).reshape(-1, 2))
        return visited[frame.contains(visited)]

    def _is_clearly_better(self, points: NDArray[np.float64], robot: SE2) -> bool:
        """Return whether a route saves the fraction replan_gain of cost and more than the lookahead distance."""
        remaining = self._travel_cost(self.points_map) + self._turn_cost(self.points_map, robot)
        saved = remaining - self._travel_cost(points) - self._turn_cost(points, robot)
        return saved > self._settings.replan_gain * remaining and saved > self._settings.lookahead

    def _travel_cost(self, points: NDArray[np.float64]) -> float:
        """Return the length of a route [m], with the costs of its cells as the search weights them."""
        rows, columns = self.costmap.frame.cell_of(points).T
        costs = np.minimum(travel_costs(self.costmap.costs[rows, columns]), COST_MAX) / COST_MAX
        weights = 1.0 + 0.5 * HIDDEN_FACTOR * self._planner.cost_travel_multiplier * (costs[1:] + costs[:-1])
        return float(np.hypot(*np.diff(points, axis=0).T) @ weights)

    def _turn_cost(self, points: NDArray[np.float64], robot: SE2) -> float:
        """Return the way that the robot could drive while it turns towards a route [m]: it would turn to and fro."""
        x, y = (points - (robot.x, robot.y)).T
        ahead = int((np.hypot(x, y) > _TURN_DISTANCE).argmax())
        turn = abs(wrap_angle(math.atan2(y[ahead], x[ahead]) - robot.yaw))
        return turn * self._settings.max_linear_velocity / self._settings.max_angular_velocity

    def _is_nearly_finished(self) -> bool:
        """Return whether the robot is near the end of a partial route, as the reward rule plans them."""
        ends_before = bool((self.points_map[-1] != self._goal).any())
        return ends_before and path_length(self.points_map) < self._settings.lookahead

    def _is_off_route(self, robot: SE2) -> bool:
        return math.hypot(*(self.points_map[0] - (robot.x, robot.y))) > _OFF_ROUTE_DISTANCE

    def _is_blocked(self, points: NDArray[np.float64]) -> bool:
        """Return whether a route enters blocked cells; where it starts in them, clearance must grow along it."""
        rows, columns = self.costmap.frame.cell_of(points).T
        blocked, clearance = self.costmap.blocked[rows, columns], self.costmap.clearance[rows, columns]
        enters = blocked[1:] & (~blocked[:-1] | (np.diff(clearance) < -_ROUNDING))
        return bool(enters.any() or blocked[-1])


def path_length(points: NDArray[np.float64]) -> float:
    """Return the length of a path through points of shape (n, 2) [m]."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def escape_path(
    clearance: NDArray[np.float32], blocked: NDArray[np.bool_], start: tuple[int, int]
) -> NDArray[np.int64] | None:
    """Return the path of steepest clearance ascent from a start to the first free cell, shape (n, 2).

    It is only the start if that is free, and None if clearance [m] stops growing before a free cell.
    """
    cells = [start]
    while blocked[cells[-1]]:
        around = _NEIGHBOURS + cells[-1]
        around = around[((around >= 0) & (around < clearance.shape)).all(axis=1)]
        gains = clearance[around[:, 0], around[:, 1]] - clearance[cells[-1]]
        gains /= np.hypot(*(around - cells[-1]).T)
        best = int(gains.argmax())
        if gains[best] <= 0.0:
            return None
        cells.append((int(around[best, 0]), int(around[best, 1])))
    return np.array(cells, dtype=np.int64)
