"""The drive controller: follows the route to the goal and stops on stale input, commands and obstacles."""

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

_TURNED = 0.02  # tolerance of a commanded turn [rad]
_ENTER_GOAL = 0.7  # within this multiple of goal_tolerance the robot turns to the goal's heading
_LEAVE_GOAL = 2.0  # beyond this multiple of goal_tolerance it drives to the goal again
_STUCK_AFTER = 5.0  # time without motion after which the robot is stuck [s]
_EDGE = 0.75  # from the centre of an occupied cell to its edge, rounded up [cells]
_STANDING = 1e-3  # below this the robot is stopped [m/s, rad/s]


class Pilot:
    """Controls the robot on its way to the goal.

    Attributes:
        replanner: route to the goal; None without a goal.
        command_state: commands of lamps that are in effect.
        goal_count: number of goals set so far.
    """

    def __init__(
        self, known: GlobalMap, planner: PlannerSettings, reward: RewardSettings, driving: DrivingSettings
    ) -> None:
        """Start at rest, without a goal.

        Args:
            global_map: map to plan on; it is only read, call `map_changed` after changes.
            planner: planning mode and robot radius.
            reward: settings of the reward rule.
            driving: velocity limits, distances and timeouts.
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
        """Points of the route [m], shape (n, 2); n is 0 if there is none."""
        return np.empty((0, 2)) if self.keeper is None else self.keeper.points_map

    def fresh_robot(self, now: float) -> PlanarPose | None:
        """Return the robot's pose if it is not older than pose_timeout at a time [s], else None."""
        is_fresh = abs(now - self._robot_at) <= self._settings.pose_timeout
        return self._robot if is_fresh else None

    def set_goal(self, T_map_goal: PlanarPose) -> None:
        """Set a goal; it replaces the previous one.

        Raises:
            DrivingError: the goal is not finite.
        """
        if not all(math.isfinite(number) for number in (T_map_goal.x, T_map_goal.y, T_map_goal.yaw)):
            raise DrivingError('the goal is not finite; give x, y and yaw')
        self._goal, self._is_there, self._is_done = T_map_goal, False, False
        self.goals += 1
        self._moved_at = math.nan
        self.orders.end_turn()  # it belonged to the previous goal
        self.keeper = RouteKeeper(self._known, (T_map_goal.x, T_map_goal.y), *self._modes, self._settings)

    def forget_goal(self) -> None:
        """Cancel the goal and stop."""
        self._goal, self.keeper, self._is_done = None, None, False

    def obey(self, command: LightCommand) -> None:
        """Apply a command of a lamp; a turn is ignored without a goal or a pose."""
        is_on_its_way = self._goal is not None and not self._is_done and self._robot is not None
        if command.operation != 'turn' or is_on_its_way:
            self.orders.obey(command)

    def robot_at(self, stamp: float, T_map_base: PlanarPose | None) -> None:
        """Set the robot's pose and its stamp [s]; None after a jump, until the poses are consistent again."""
        self._robot, self._robot_at = T_map_base, stamp
        if T_map_base is None:
            self.orders.end_turn()  # poses across a jump do not measure the turn
        else:
            self.orders.robot_heads(T_map_base.yaw)

    def map_changed(self, stamp: float, part: GridFrame) -> None:
        """Update the route for the part of the map that a frame changed; the frame's stamp is in seconds."""
        self._map_at = stamp
        if self.keeper is not None:
            self.keeper.map_changed(part)

    def map_cleared(self) -> None:
        """Restart with an empty map; the robot stops until the next frame is mapped."""
        self._map_at = -math.inf
        if self.keeper is not None:
            self.keeper.forget()

    def time_jumped(self) -> None:
        """Reset pose, timers and goal after a jump of the clock."""
        self._robot, self._robot_at, self._map_at = None, -math.inf, -math.inf
        self._stepped_at = math.nan
        self.orders.end_turn()
        self.forget_goal()

    def step(self, now: float) -> Drive:
        """Run one control cycle at a time [s]."""
        elapsed = 0.0 if math.isnan(self._stepped_at) else now - self._stepped_at
        self._stepped_at = now
        state, detail, wanted, waypoint = self._decide(now)
        stood = self._ramp.velocity == Velocity()
        velocity = self._ramp.toward(wanted, elapsed)
        if state is DriveState.REACHED and stood:
            self._is_done = True  # later poses do not restart the drive
        if state is DriveState.DRIVING and self._has_stood(now, velocity):
            state, detail = (
                DriveState.STUCK,
                f'{DriveState.STUCK.value}: obstacles or lamps allow no speed',
            )
        # Publish zero velocity once before cmd_vel is released to other nodes.
        leaves = stood and velocity == Velocity() and state in (DriveState.IDLE, DriveState.REACHED)
        return Drive(state, detail, None if leaves else velocity, waypoint)

    def _decide(self, now: float) -> tuple[DriveState, str, Velocity, tuple[float, float] | None]:
        """Return state, detail, target velocity and lookahead point."""
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
        """Return whether a robot that should drive has not moved for long."""
        moves = max(abs(velocity.forward), abs(velocity.turn_rate)) > _STANDING
        if moves or not now >= self._moved_at:
            self._moved_at = now
        return now - self._moved_at > _STUCK_AFTER

    def _doubt(self, now: float) -> tuple[DriveState, str] | None:
        """Return state and reason if pose or map is missing or stale, else None."""
        if self._robot is None:
            detail = 'no pose received' if self._robot_at == -math.inf else 'the pose jumped'
            return DriveState.LOST, f'{DriveState.LOST.value}: {detail}'
        for state, came, limit, what in (
            (DriveState.LOST, self._robot_at, self._settings.pose_timeout, 'pose'),
            (DriveState.BLIND, self._map_at, self._settings.map_timeout, 'frame'),
        ):
            if not abs(now - came) <= limit:
                age = f'the latest {what} is older than {limit:g} s or in the future'
                return state, f'{state.value}: {age if came > -math.inf else f"no {what} received"}'
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
        """Follow the route, and turn to the goal's heading at its end."""
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
            return DriveState.DRIVING, "turning to the goal's heading", self._spin(left), None
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
        """Return the speed that commands, obstacles and the goal allow [m/s]."""
        area, settings = keeper.area, self._settings
        rim = self._modes[0].robot_radius
        reach = max(settings.lookahead, 2.0 * self._ramp.braking_distance())
        free, clearance = free_ahead(area, robot, rim + _EDGE * area.frame.resolution, reach)
        # The nearest point may be behind the robot; the next one is ahead.
        ahead = keeper.points_map[min(1, len(keeper.points_map) - 1) :]
        to_goal = length_of(ahead) + math.hypot(*(ahead[0] - (robot.x, robot.y)))
        return min(
            self.orders.speed,
            speed_near_obstacles(clearance - rim, settings),
            speed_for_stop(free, settings) if free < reach else math.inf,
            speed_for_stop(to_goal, settings),
        )
