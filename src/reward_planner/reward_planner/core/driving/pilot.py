"""Drives the robot to its goal: stops, turns, drives on, always by what it knows now."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drive import Drive, DriveState
from reward_planner.core.driving.driving_error import DrivingError
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.light_command import LightCommand
from reward_planner.core.driving.light_orders import LightOrders
from reward_planner.core.driving.route_keeper import RouteKeeper, length_of
from reward_planner.core.driving.steering import (
    drive_towards,
    speed_for_stop,
    speed_near_obstacles,
    turn_by,
)
from reward_planner.core.driving.velocity_ramp import Velocity, VelocityRamp
from reward_planner.core.driving.waypoint import free_ahead, next_waypoint
from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from shirube_geometry import PlanarPose, wrap_angle

_TURNED = 0.02  # a turn that a lamp asked for is done when so little is left [rad]
_ENTER_GOAL = 0.7  # times the tolerance: so near the robot begins to turn to the goal's heading
_LEAVE_GOAL = 2.0  # times the tolerance: a robot that slips farther away while it turns drives there again
_STUCK_AFTER = 5.0  # a robot that has stood so long on its way says so [s]
_EDGE = 0.75  # cells: from the centre of an occupied cell to its border and a little more
_STANDING = 1e-3  # [m/s, rad/s]


class Pilot:
    """The robot's driver.

    Attributes:
        keeper: of the route; None without a goal.
        orders: of the lamps.
        goals: how many were set.
    """

    def __init__(
        self, known: GlobalMap, planner: PlannerSettings, reward: RewardSettings, driving: DrivingSettings
    ) -> None:
        """Begin at rest, without a goal.

        Args:
            known: the map; it is read, and `map_changed` says where and when.
            planner: mode and size of the robot.
            reward: of the reward rule.
            driving: limits and distances.
        """
        self.keeper: RouteKeeper | None = None
        self.orders = LightOrders(driving.max_linear_velocity)
        self._known, self._settings = known, driving
        self._modes = (planner, reward)
        self._ramp = VelocityRamp(driving)
        self.goals = 0
        self._goal: PlanarPose | None = None
        self._is_there = self._is_done = False
        self._moved_at = math.nan
        self._robot: PlanarPose | None = None
        self._robot_at = self._map_at = -math.inf
        self._stepped_at = math.nan

    @property
    def points_map(self) -> NDArray[np.float64]:
        """The route, shape (n, 2) [m]; n is 0 where there is none."""
        return np.empty((0, 2)) if self.keeper is None else self.keeper.points_map

    def fresh_robot(self, now: float) -> PlanarPose | None:
        """Return where the robot is at a time [s]; None where its poses are too old or cannot be trusted."""
        is_fresh = abs(now - self._robot_at) <= self._settings.pose_timeout
        return self._robot if is_fresh else None

    def set_goal(self, T_map_goal: PlanarPose) -> None:
        """Take a goal; the one before is forgotten.

        Raises:
            DrivingError: a number that is not finite.
        """
        if not all(math.isfinite(number) for number in (T_map_goal.x, T_map_goal.y, T_map_goal.yaw)):
            raise DrivingError('the goal is not finite; give x, y and yaw')
        self._goal, self._is_there, self._is_done = T_map_goal, False, False
        self.goals += 1
        self._moved_at = math.nan
        self.orders.end_turn()  # it was meant for the way to another goal
        self.keeper = RouteKeeper(self._known, (T_map_goal.x, T_map_goal.y), *self._modes, self._settings)

    def forget_goal(self) -> None:
        """Stop, and wait for a goal."""
        self._goal, self.keeper, self._is_done = None, None, False

    def obey(self, command: LightCommand) -> None:
        """Take a command of a lamp; a turn is made now or never: not without a goal or a pose."""
        is_on_its_way = self._goal is not None and not self._is_done and self._robot is not None
        if command.operation != 'turn' or is_on_its_way:
            self.orders.obey(command)

    def robot_at(self, stamp: float, T_map_base: PlanarPose | None) -> None:
        """Take where the robot is at a time, the stamp of its pose [s]; None where its poses cannot be trusted."""
        self._robot, self._robot_at = T_map_base, stamp
        if T_map_base is None:
            self.orders.end_turn()  # what poses say after a jump tells nothing of how far it has turned
        else:
            self.orders.robot_heads(T_map_base.yaw)

    def map_changed(self, stamp: float, part: GridFrame) -> None:
        """Take which part of the map a frame has changed, and the frame's stamp [s]."""
        self._map_at = stamp
        if self.keeper is not None:
            self.keeper.map_changed(part)

    def map_cleared(self) -> None:
        """Begin again on an empty map; the robot stands until it has seen something."""
        self._map_at = -math.inf
        if self.keeper is not None:
            self.keeper.forget()

    def time_jumped(self) -> None:
        """Forget when things came, and the goal."""
        self._robot, self._robot_at, self._map_at = None, -math.inf, -math.inf
        self._stepped_at = math.nan
        self.orders.end_turn()
        self.forget_goal()

    def step(self, now: float) -> Drive:
        """Return what is to be done at a time [s]; to be called regularly."""
        elapsed = 0.0 if math.isnan(self._stepped_at) else now - self._stepped_at
        self._stepped_at = now
        state, detail, wanted, waypoint = self._decide(now)
        stood = self._ramp.velocity == Velocity()
        velocity = self._ramp.toward(wanted, elapsed)
        if state is DriveState.REACHED and stood:
            self._is_done = True  # others may drive on now, and no later pose makes the robot come back
        if state is DriveState.DRIVING and self._has_stood(now, velocity):
            state, detail = (
                DriveState.STUCK,
                f'{DriveState.STUCK.value}: obstacles or lamps leave it no speed',
            )
        # The velocity of standing is given once before the motors are left to others.
        leaves = stood and velocity == Velocity() and state in (DriveState.IDLE, DriveState.REACHED)
        return Drive(state, detail, None if leaves else velocity, waypoint)

    def _decide(self, now: float) -> tuple[DriveState, str, Velocity, tuple[float, float] | None]:
        """Return state, detail, wanted velocity and waypoint."""
        robot, stand = self._robot, Velocity()
        if self._goal is None or self.keeper is None or self._is_done:
            state = DriveState.REACHED if self._is_done else DriveState.IDLE
            return state, state.value, stand, None
        doubt = self._doubt(now)
        if doubt is not None or robot is None:
            state, detail = doubt or (DriveState.LOST, '')
            return state, detail, stand, None
        try:
            self.keeper.update(now, robot)
        except DrivingError as fault:
            return DriveState.UNREACHABLE, str(fault), stand, None
        if self.orders.is_stopped or self.orders.speed <= _STANDING:
            return DriveState.HELD, DriveState.HELD.value, stand, None
        if self.orders.left_to_turn != 0.0:
            return DriveState.TURNING, DriveState.TURNING.value, self._turn(), None
        return self._approach(robot, self._goal, self.keeper)

    def _has_stood(self, now: float, velocity: Velocity) -> bool:
        """Return whether a robot that should drive has stood for long."""
        moves = max(abs(velocity.forward), abs(velocity.turn_rate)) > _STANDING
        if moves or not now >= self._moved_at:
            self._moved_at = now
        return now - self._moved_at > _STUCK_AFTER

    def _doubt(self, now: float) -> tuple[DriveState, str] | None:
        """Return why the robot does not know enough to move."""
        if self._robot is None:
            detail = 'there is no pose' if self._robot_at == -math.inf else 'poses jump'
            return DriveState.LOST, f'{DriveState.LOST.value}: {detail}'
        for state, came, limit, what in (
            (DriveState.LOST, self._robot_at, self._settings.pose_timeout, 'pose'),
            (DriveState.BLIND, self._map_at, self._settings.map_timeout, 'frame'),
        ):
            if not abs(now - came) <= limit:
                age = f'the newest {what} is more than {limit:g} s away from now'
                return state, f'{state.value}: {age if came > -math.inf else f"no {what} came yet"}'
        return None

    def _turn(self) -> Velocity:
        left = self.orders.left_to_turn
        if self._ramp.velocity.forward > _STANDING:
            return Velocity()
        if abs(left) <= _TURNED:
            self.orders.end_turn()
            return Velocity()
        return Velocity(0.0, turn_by(left, self._settings))

    def _approach(
        self, robot: PlanarPose, goal: PlanarPose, keeper: RouteKeeper
    ) -> tuple[DriveState, str, Velocity, tuple[float, float] | None]:
        """Drive along the route, and turn to the goal's heading when there."""
        tolerance, distance = self._settings.goal_tolerance, robot.distance_to(goal)
        left = robot.turn_to(goal)
        is_turned = abs(left) <= self._settings.goal_yaw_tolerance
        if self._is_there:
            self._is_there = distance <= tolerance * (1.0 if is_turned else _LEAVE_GOAL)
        else:
            self._is_there = distance <= tolerance * _ENTER_GOAL
        if self._is_there:
            if is_turned:
                return DriveState.REACHED, DriveState.REACHED.value, Velocity(), None
            return DriveState.DRIVING, 'turning to the heading of the goal', self._spin(left), None
        if len(keeper.points_map) == 0:
            why = '' if keeper.problem is None else f': {keeper.problem.value}'
            return DriveState.UNREACHABLE, f'{DriveState.UNREACHABLE.value}{why}', Velocity(), None
        waypoint = next_waypoint(keeper.area, robot, keeper.points_map, self._settings.lookahead)
        bearing = wrap_angle(math.atan2(waypoint[1] - robot.y, waypoint[0] - robot.x) - robot.yaw)
        speed = self._speed(robot, keeper)
        wanted = drive_towards(bearing, speed, self._settings)
        return DriveState.DRIVING, DriveState.DRIVING.value, wanted, (float(waypoint[0]), float(waypoint[1]))

    def _spin(self, left: float) -> Velocity:
        return Velocity(0.0, turn_by(left, self._settings))

    def _speed(self, robot: PlanarPose, keeper: RouteKeeper) -> float:
        """Return the speed that lamps, obstacles and the goal allow [m/s]."""
        area, settings = keeper.area, self._settings
        rim = self._modes[0].robot_radius
        reach = max(settings.lookahead, 2.0 * self._ramp.braking_distance())
        free, clearance = free_ahead(area, robot, rim + _EDGE * area.frame.resolution, reach)
        # The first point is the nearest one, which may lie behind; the next one lies ahead.
        ahead = keeper.points_map[min(1, len(keeper.points_map) - 1) :]
        to_goal = length_of(ahead) + math.hypot(*(ahead[0] - (robot.x, robot.y)))
        return min(
            self.orders.speed,
            speed_near_obstacles(clearance - rim, settings),
            speed_for_stop(free, settings) if free < reach else math.inf,
            speed_for_stop(to_goal, settings),
        )
