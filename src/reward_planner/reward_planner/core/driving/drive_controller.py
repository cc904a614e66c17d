"""The drive controller: follows the route to the goal and stops on stale input, commands and obstacles."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.fixed_route import FixedRoute
from reward_planner.core.driving.light_command import LightCommand, LightCommandState
from reward_planner.core.driving.look_around import LookAround
from reward_planner.core.driving.path_following import (
    braking_speed_limit,
    check_path_ahead,
    lookahead_point,
    obstacle_speed_limit,
    turn_rate_for_angle,
    velocity_towards,
)
from reward_planner.core.driving.replanner import Replanner, path_length
from reward_planner.core.driving.velocity_smoother import Velocity, VelocitySmoother
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.planner_settings import PlannerSettings, RewardSettings
from reward_planner.core.reward_planner_error import DrivingError
from shirube_core.geometry import SE2, wrap_angle

_TURN_TOLERANCE = 0.02  # tolerance of a commanded turn [rad]
_GOAL_ENTER_FACTOR = 0.7  # within this multiple of goal_tolerance the robot turns to the goal's heading
_GOAL_LEAVE_FACTOR = 2.0  # beyond this multiple of goal_tolerance it drives to the goal again
_STUCK_TIMEOUT = 5.0  # time without motion after which the robot is stuck [s]
_CELL_MARGIN = 0.75  # from the centre of an occupied cell to its edge, rounded up [cells]
_LOOK_FRACTION = 0.5  # of the maximum turn rate while looking around: frames overlap
_STOPPED_SPEED = 1e-3  # below this the robot is stopped [m/s, rad/s]


class DriveController:
    """Controls the robot on its way to the goal.

    Attributes:
        replanner: route to the goal; None without a goal.
        command_state: commands of lamps that are in effect.
        goal: the goal in the map; None without one.
        goal_count: number of goals set so far.
    """

    def __init__(
        self,
        global_map: GlobalMap,
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
    ) -> None:
        """Start at rest, without a goal; arguments as for `Replanner`."""
        self.replanner: Replanner | None = None
        self.command_state = LightCommandState(driving.max_linear_velocity)
        self._global_map, self._settings = global_map, driving
        self._planner, self._reward = planner, reward
        self._smoother = VelocitySmoother(driving)
        self._look_around = LookAround(global_map) if driving.look_around else None
        self.goal_count = 0
        self.goal: SE2 | None = None
        self._path: NDArray[np.float64] | None = None
        self._is_at_goal = self._is_goal_reached = False
        self._last_motion_time = math.nan
        self._pose: SE2 | None = None
        self._pose_stamp = self._map_stamp = -math.inf
        self._last_step_time = math.nan

    def apply_settings(
        self, planner: PlannerSettings, reward: RewardSettings, driving: DrivingSettings
    ) -> None:
        """Use other settings, but for ``look_around``; the route to the goal is planned again."""
        self._planner, self._reward, self._settings = planner, reward, driving
        self._smoother.settings = driving
        self.command_state.set_speed_max(driving.max_linear_velocity)
        if self.replanner is not None and self.goal is not None:
            count = self.replanner.replan_count
            self.replanner = self._make_replanner(self.goal)
            self.replanner.replan_count = count

    @property
    def points_map(self) -> NDArray[np.float64]:
        """Points of the route [m], shape (n, 2); n is 0 if there is none."""
        return np.empty((0, 2)) if self.replanner is None else self.replanner.points_map

    def fresh_pose(self, now: float) -> SE2 | None:
        """Return the robot's pose if it is not older than pose_timeout at a time [s], else None."""
        is_fresh = abs(now - self._pose_stamp) <= self._settings.pose_timeout
        return self._pose if is_fresh else None

    def set_goal(self, T_map_goal: SE2, path_map: NDArray[np.float64] | None = None) -> None:
        """Set a goal; it replaces the previous one. A path to it [m], shape (n, 2), replaces planning.

        Raises:
            DrivingError: the goal is not finite.
        """
        if not all(math.isfinite(number) for number in (T_map_goal.x, T_map_goal.y, T_map_goal.yaw)):
            raise DrivingError('the goal is not finite; give x, y and yaw')
        self.goal, self._is_at_goal, self._is_goal_reached = T_map_goal, False, False
        self.goal_count += 1
        self._last_motion_time = math.nan
        self.command_state.cancel_turn()  # it belonged to the previous goal
        self._path = path_map
        self.replanner = self._make_replanner(T_map_goal)

    def _make_replanner(self, goal: SE2) -> Replanner:
        settings = (self._global_map, self._planner, self._reward, self._settings)
        if self._path is not None:
            return FixedRoute(self._path, *settings)
        return Replanner(self._global_map, (goal.x, goal.y), *settings[1:])

    def cancel_goal(self) -> None:
        """Cancel the goal and stop."""
        self.goal, self.replanner, self._is_goal_reached = None, None, False

    def halt(self) -> None:
        """Cancel the goal of a robot that was stopped."""
        self.cancel_goal()
        self._smoother.halt()

    def apply_command(self, command: LightCommand) -> None:
        """Apply a command of a lamp; a turn is ignored without a goal or a pose."""
        is_on_its_way = self.goal is not None and not self._is_goal_reached and self._pose is not None
        if command.operation != 'turn' or is_on_its_way:
            self.command_state.apply_command(command)

    def update_pose(self, stamp: float, T_map_base: SE2 | None) -> None:
        """Set the robot's pose and its stamp [s]; None after a jump, until the poses are consistent again."""
        self._pose, self._pose_stamp = T_map_base, stamp
        if T_map_base is None:
            self.command_state.cancel_turn()  # poses across a jump do not measure the turn
        else:
            self.command_state.update_heading(T_map_base.yaw)

    def update_map(self, stamp: float, part: GridFrame) -> None:
        """Update the route for the part of the map that a frame changed; the frame's stamp is in seconds."""
        self._map_stamp = stamp
        if self.replanner is not None:
            self.replanner.update_map(part)

    def reset_map(self) -> None:
        """Restart with an empty map; the robot stops until the next frame is mapped."""
        self._map_stamp = -math.inf
        if self.replanner is not None:
            self.replanner.reset()
        if self._look_around is not None:
            self._look_around.reset()

    def handle_time_jump(self) -> None:
        """Reset pose, timers and goal after a jump of the clock."""
        self._pose, self._pose_stamp, self._map_stamp = None, -math.inf, -math.inf
        self._last_step_time = math.nan
        self.command_state.cancel_turn()
        self.cancel_goal()

    def step(self, now: float) -> DriveCommand:
        """Run one control cycle at a time [s]."""
        elapsed = 0.0 if math.isnan(self._last_step_time) else now - self._last_step_time
        self._last_step_time = now
        drive = self._decide(now)
        was_stopped = self._smoother.velocity == Velocity()
        velocity = self._smoother.step_toward(drive.velocity or Velocity(), elapsed)
        if drive.state is DriveState.GOAL_REACHED and was_stopped:
            self._is_goal_reached = True  # later poses do not restart the drive
        if drive.state is DriveState.DRIVING and self._is_stuck(now, velocity):
            detail = f'{DriveState.STUCK.value}: obstacles or lamps allow no speed'
            drive = replace(drive, state=DriveState.STUCK, detail=detail)
        # Publish zero velocity once before cmd_vel is released to other nodes.
        is_idle = drive.state in (DriveState.IDLE, DriveState.GOAL_REACHED)
        is_released = is_idle and was_stopped and velocity == Velocity()
        return replace(drive, velocity=None if is_released else velocity)

    def _decide(self, now: float) -> DriveCommand:
        """Return state and detail, with the target velocity and the lookahead point."""
        # Without a goal there is nothing to do.
        if self.goal is None or self.replanner is None or self._is_goal_reached:
            return _stop(DriveState.GOAL_REACHED if self._is_goal_reached else DriveState.IDLE)
        # 1. Input: pose and map must be fresh.
        stale = self._stale_input(now)
        robot = self._pose
        if stale is not None or robot is None:
            return stale or _stop(DriveState.LOST)
        # 2. Route: keep or replace it.
        try:
            self.replanner.update(now, robot)
        except DrivingError as fault:
            return _stop(DriveState.UNREACHABLE, str(fault))
        # 3. Commands of lamps, and 4. unknown surroundings come before the route.
        return self._command_in_place(robot) or self._follow_route(robot, self.goal, self.replanner)

    def _command_in_place(self, robot: SE2) -> DriveCommand | None:
        """Return the stop or turn that lamps command, or the turn to look around (the paper's step 1)."""
        if self.command_state.is_stopped or self.command_state.speed_limit <= _STOPPED_SPEED:
            return _stop(DriveState.STOPPED_BY_LAMP)
        if self.command_state.remaining_turn != 0.0:
            return DriveCommand(DriveState.TURNING, DriveState.TURNING.value, self._turn_on_command())
        if self._look_around is not None and self._look_around.update(robot):
            turn = self._turn_in_place(_LOOK_FRACTION * self._settings.max_angular_velocity)
            return DriveCommand(DriveState.LOOKING_AROUND, DriveState.LOOKING_AROUND.value, turn)
        return None

    def _follow_route(self, robot: SE2, goal: SE2, replanner: Replanner) -> DriveCommand:
        # 5. At the goal: turn to its heading.
        remaining = robot.yaw_to(goal)
        is_turned = abs(remaining) <= self._settings.goal_yaw_tolerance
        if self._check_at_goal(robot.distance_to(goal), is_turned=is_turned):
            if is_turned:
                return _stop(DriveState.GOAL_REACHED)
            turn = Velocity(0.0, turn_rate_for_angle(remaining, self._settings))
            return DriveCommand(DriveState.DRIVING, "turning to the goal's heading", turn)
        # 6. Follow the route: towards the lookahead point, as fast as commands, obstacles and the goal allow.
        if len(replanner.points_map) == 0:
            why = '' if replanner.no_route_reason is None else f': {replanner.no_route_reason.value}'
            return _stop(DriveState.UNREACHABLE, f'{DriveState.UNREACHABLE.value}{why}')
        x, y = lookahead_point(replanner.costmap, robot, replanner.points_map, self._settings.lookahead)
        bearing = wrap_angle(math.atan2(y - robot.y, x - robot.x) - robot.yaw)
        target = velocity_towards(bearing, self._allowed_speed(robot, replanner), self._settings)
        return DriveCommand(DriveState.DRIVING, DriveState.DRIVING.value, target, (float(x), float(y)))

    def _check_at_goal(self, distance: float, *, is_turned: bool) -> bool:
        """Return whether the robot is at the goal, with hysteresis while it turns to the goal's heading."""
        leave = 1.0 if is_turned else _GOAL_LEAVE_FACTOR
        factor = leave if self._is_at_goal else _GOAL_ENTER_FACTOR
        self._is_at_goal = distance <= self._settings.goal_tolerance * factor
        return self._is_at_goal

    def _is_stuck(self, now: float, velocity: Velocity) -> bool:
        """Return whether a robot that should drive has not moved for long."""
        moves = max(abs(velocity.forward), abs(velocity.turn_rate)) > _STOPPED_SPEED
        if moves or not now >= self._last_motion_time:
            self._last_motion_time = now
        return now - self._last_motion_time > _STUCK_TIMEOUT

    def _stale_input(self, now: float) -> DriveCommand | None:
        """Return a stop with its reason if pose or map is missing or stale, else None."""
        if self._pose is None:
            detail = 'no pose received' if self._pose_stamp == -math.inf else 'the pose jumped'
            return _stop(DriveState.LOST, f'{DriveState.LOST.value}: {detail}')
        for state, stamp, limit, what in (
            (DriveState.LOST, self._pose_stamp, self._settings.pose_timeout, 'pose'),
            (DriveState.MAP_STALE, self._map_stamp, self._settings.map_timeout, 'frame'),
        ):
            if not abs(now - stamp) <= limit:
                age = f'the latest {what} is older than {limit:g} s or in the future'
                why = age if stamp > -math.inf else f'no {what} received'
                return _stop(state, f'{state.value}: {why}')
        return None

    def _turn_on_command(self) -> Velocity:
        remaining = self.command_state.remaining_turn
        is_stopped = self._smoother.velocity.forward <= _STOPPED_SPEED
        if is_stopped and abs(remaining) <= _TURN_TOLERANCE:
            self.command_state.cancel_turn()
            return Velocity()
        return self._turn_in_place(turn_rate_for_angle(remaining, self._settings))

    def _turn_in_place(self, turn_rate: float) -> Velocity:
        """Return a turn rate [rad/s] once the robot has stopped."""
        is_stopped = self._smoother.velocity.forward <= _STOPPED_SPEED
        return Velocity(0.0, turn_rate) if is_stopped else Velocity()

    def _allowed_speed(self, robot: SE2, replanner: Replanner) -> float:
        """Return the speed that commands, obstacles and the goal allow [m/s]."""
        costmap, settings = replanner.costmap, self._settings
        robot_radius = self._planner.robot_radius
        distance_max = max(settings.lookahead, 2.0 * self._smoother.braking_distance())
        free_distance, clearance = check_path_ahead(
            costmap, robot, robot_radius + _CELL_MARGIN * costmap.frame.resolution, distance_max
        )
        # The nearest point may be behind the robot; the next one is ahead.
        ahead = replanner.points_map[min(1, len(replanner.points_map) - 1) :]
        to_goal = path_length(ahead) + math.hypot(*(ahead[0] - (robot.x, robot.y)))
        return min(
            self.command_state.speed_limit,
            obstacle_speed_limit(clearance - robot_radius, settings),
            braking_speed_limit(free_distance, settings) if free_distance < distance_max else math.inf,
            braking_speed_limit(to_goal, settings),
        )


def _stop(state: DriveState, detail: str = '') -> DriveCommand:
    return DriveCommand(state, detail or state.value, Velocity())
