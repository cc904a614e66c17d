"""The drive controller: follows the route to the goal and stops on stale input, commands and obstacles."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drive_state import (
    DriveCommand,
    DriveInputs,
    DriveState,
    Velocity,
    VelocitySmoother,
    stop_command,
)
from reward_planner.core.driving.fixed_route import FixedRoute
from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.driving.light_command import LightCommand, LightCommandState
from reward_planner.core.driving.moving_obstacle_policy import (
    AROUND_TIME,
    MovingObstacle,
    MovingObstaclePolicy,
    nearby_obstacles,
    obstacle_cells,
    with_obstacles,
)
from reward_planner.core.driving.path_following import (
    GoalArrival,
    braking_speed_limit,
    lookahead_point,
    mask_speed_limit,
    route_speed_limit,
    velocity_towards,
)
from reward_planner.core.driving.recovery import LookAround, Recovery, RecoveryBehavior
from reward_planner.core.driving.replanner import Replanner
from reward_planner.core.driving.route_planning import RoutePlanning, RunPlanning, run_at_once
from reward_planner.core.driving.stuck_check import STUCK_DETAIL, StuckCheck
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import GridFrame
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.settings import DrivingSettings, PlannerSettings, RewardSettings
from shirube_core.geometry import SE2, wrap_angle

_LOOK_FRACTION = 0.5  # of the maximum turn rate while looking around: frames overlap
_REACH_MARGIN = 1.0  # of the costmap around the robot, which may be off its route [m]
_HELD_FRACTION = 0.25  # of the lookahead distance where the robot was held
_GAP = 0.5  # kept before the path of a moving obstacle [m]: nearer, people would wait for the robot
_STOPPED_SPEED = 1e-3  # below this the robot is stopped [m/s, rad/s]


class DriveController:
    """Controls the robot on its way to the goal.

    Attributes:
        replanner: planning of the route to the goal; None without a goal.
        command_state: commands of lamps that are in effect.
        goal: the goal in the map; None without one.
        goal_count: number of goals set so far.
        moving_obstacles: obstacles that move, with their prediction; they are not in the map.
        recovery: recovery behaviors of a robot without a route.
    """

    def __init__(
        self,
        global_map: GlobalMap,
        planner: PlannerSettings,
        reward: RewardSettings,
        driving: DrivingSettings,
        *,
        clear_around: Callable[[SE2, float], None] | None = None,
    ) -> None:
        """Start at rest, without a goal; arguments as for `Replanner`, and the recovery's way to clear the map."""
        self.replanner: RoutePlanning | None = None
        self.run_planning: RunPlanning = run_at_once
        self.command_state = LightCommandState(driving.max_linear_velocity)
        self.moving_obstacles: Sequence[MovingObstacle] = ()
        self.recovery = Recovery(clear_around, self._discard_route)
        self.goal: SE2 | None = None
        self.goal_count, self._stuck, self._last_step_time = 0, StuckCheck(), math.nan
        self._global_map, self._settings = global_map, driving
        self._planner, self._reward = planner, reward
        self._smoother = VelocitySmoother(driving)
        self._look_around = LookAround(global_map) if driving.look_around else None
        self._policy, self._inputs = MovingObstaclePolicy(), DriveInputs()
        self._path: NDArray[np.float64] | None = None
        self._arrival, self._is_goal_reached = GoalArrival(), False

    def apply_settings(self, planner: PlannerSettings, reward: RewardSettings, driving: DrivingSettings) -> None:
        """Use other settings, but for ``look_around``; the route to the goal is planned again."""
        self._planner, self._reward, self._settings = planner, reward, driving
        self._smoother.settings = driving
        self.command_state.set_speed_max(driving.max_linear_velocity)
        if self.replanner is not None and self.goal is not None:
            self.replanner = self._plan_to(self.goal, self.replanner)

    @property
    def points_map(self) -> NDArray[np.float64]:
        """Points of the route [m], shape (n, 2); n is 0 if there is none."""
        return np.empty((0, 2)) if self.replanner is None else self.replanner.points_map

    def fresh_pose(self, now: float) -> SE2 | None:
        """Return the robot's pose if it is not older than pose_timeout at a time [s], else None."""
        return self._inputs.pose if abs(now - self._inputs.pose_stamp) <= self._settings.pose_timeout else None

    def set_goal(self, T_map_goal: SE2, path_map: NDArray[np.float64] | None = None) -> None:
        """Set a goal; it replaces the previous one. A path to it [m], shape (n, 2), replaces planning.

        Raises:
            DrivingError: the goal is not finite; the previous one stays.
        """
        if not all(math.isfinite(number) for number in (T_map_goal.x, T_map_goal.y, T_map_goal.yaw)):
            raise DrivingError('the goal is not finite; give x, y and yaw')
        self.goal, self._arrival, self._is_goal_reached = T_map_goal, GoalArrival(), False
        self.goal_count += 1
        self._stuck.reset()
        self.command_state.cancel_turn()  # it belonged to the previous goal
        self._path = path_map
        self.recovery.reset()
        self._policy.reset()
        self.replanner = self._plan_to(T_map_goal)

    def _plan_to(self, goal: SE2, previous: RoutePlanning | None = None) -> RoutePlanning:
        settings, path = (self._planner, self._reward, self._settings), self._path

        def make(planning_map: GlobalMap) -> Replanner:
            if path is not None:
                return FixedRoute(path, planning_map, *settings)
            return Replanner(planning_map, (goal.x, goal.y), *settings)

        return RoutePlanning(self._global_map, make, self.run_planning, previous)

    def cancel_goal(self) -> None:
        """Cancel the goal and stop."""
        self.goal, self.replanner, self._is_goal_reached = None, None, False

    def halt(self) -> None:
        """Cancel the goal of a robot that was stopped."""
        self.cancel_goal()
        self._smoother.halt()

    def apply_command(self, command: LightCommand) -> None:
        """Apply a command of a lamp; a turn is ignored without a goal or a pose."""
        is_on_its_way = self.goal is not None and not self._is_goal_reached and self._inputs.pose is not None
        if command.operation != 'turn' or is_on_its_way:
            self.command_state.apply_command(command)

    def update_pose(self, stamp: float, T_map_base: SE2 | None) -> None:
        """Set the robot's pose and its stamp [s]; None after a jump, until the poses are consistent again."""
        self._inputs.pose, self._inputs.pose_stamp = T_map_base, stamp
        if T_map_base is None:
            self.command_state.cancel_turn()  # poses across a jump do not measure the turn
        else:
            self.command_state.update_heading(T_map_base.yaw)

    def update_map(self, stamp: float, part: GridFrame | None) -> None:
        """Update the route for the part of the map that a frame [s] changed; None if obstacles fill its view."""
        if part is None:
            self._inputs.near_stamp = stamp
            return
        self._inputs.map_stamp = stamp
        self.update_cells(part)

    def update_cells(self, part: GridFrame) -> None:
        """Update the route for a part of the map that changed without a frame."""
        if self.replanner is not None:
            self.replanner.update_map(part)

    def reset_map(self) -> None:
        """Restart with an empty map; the robot stops until the next frame is mapped."""
        self._inputs.map_stamp = -math.inf
        self._discard_route()
        if self._look_around is not None:
            self._look_around.reset()

    def handle_time_jump(self) -> None:
        """Reset pose, timers and goal after a jump of the clock."""
        self._inputs = DriveInputs()
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
        drive = self._stuck.checked(now, self._inputs.pose, drive)
        # Publish zero velocity once before cmd_vel is released to other nodes.
        is_idle = drive.state in (DriveState.IDLE, DriveState.GOAL_REACHED)
        is_released = is_idle and was_stopped and velocity == Velocity()
        return replace(drive, velocity=None if is_released else velocity)

    def _discard_route(self) -> None:
        if self.replanner is not None:
            self.replanner.reset()

    def _decide(self, now: float) -> DriveCommand:
        """Return state and detail, with the target velocity and the lookahead point."""
        if self.goal is None or self.replanner is None or self._is_goal_reached:
            return stop_command(DriveState.GOAL_REACHED if self._is_goal_reached else DriveState.IDLE)
        # 1. Input: pose and map must be fresh.
        robot = self._inputs.pose
        if (stale := self._inputs.stale(now, self._settings)) or robot is None:
            if robot is not None and stale is not None and stale.state is DriveState.RECOVERING:
                return self._command_in_place(robot) or stale
            return stale or stop_command(DriveState.LOST)
        # 2. Route: keep or replace it.
        self.replanner.update(now, robot)
        if self.replanner.error:
            return stop_command(DriveState.UNREACHABLE, self.replanner.error)
        # 3. Commands of lamps and 4. unknown surroundings come before 5. the goal's heading and the route.
        command = self._command_in_place(robot) or self._arrival.update(robot, self.goal, self._settings)
        return command or self._follow_route(now, robot, self.replanner)

    def _command_in_place(self, robot: SE2) -> DriveCommand | None:
        """Return the stop or turn that lamps command, or the turn to look around (the paper's step 1)."""
        if self.command_state.is_stopped or self.command_state.speed_limit <= _STOPPED_SPEED:
            return stop_command(DriveState.STOPPED_BY_LAMP)
        if self.command_state.remaining_turn != 0.0:
            is_stopped = abs(self._smoother.velocity.forward) <= _STOPPED_SPEED
            turn = self._turn_in_place(self.command_state.turn_rate(self._settings, is_stopped=is_stopped))
            return DriveCommand(DriveState.TURNING, DriveState.TURNING.value, turn)
        if self._look_around is not None and self._look_around.update(robot):
            turn = self._turn_in_place(_LOOK_FRACTION * self._settings.max_angular_velocity)
            return DriveCommand(DriveState.LOOKING_AROUND, DriveState.LOOKING_AROUND.value, turn)
        return None

    def _follow_route(self, now: float, robot: SE2, planning: RoutePlanning) -> DriveCommand:
        """Follow the route (6.) towards the lookahead point, or act as long as there is none."""
        obstacles, settings = nearby_obstacles(self.moving_obstacles, robot, now), self._settings
        self._stuck.note_people(now, robot, obstacles)
        planning.is_kept = self._stuck.is_oscillating and not self.recovery.must_finish
        # Moving obstacles: wait for them, or plan around them. Without a route, the last one with a conflict counts.
        motion = robot, self._smoother.velocity.forward, planning.robot_radius + settings.clearance_margin
        free = self._policy.react(planning.points_map, motion, obstacles, now, settings)
        avoided = obstacles if self._policy.is_around else ()
        planning.set_obstacles(obstacle_cells(avoided, now, AROUND_TIME, self._global_map.resolution))
        if self._policy.is_detour_long and not planning.is_kept:
            return stop_command(DriveState.WAITING, f'{DriveState.WAITING.value}: the way around it is long')
        known = with_obstacles(self._global_map, obstacles, now)
        if len(planning.points_map) == 0 or self.recovery.must_finish:
            return self._act_without_route(now, robot, planning, known)
        if self._stuck.is_stuck:
            if command := self._recover(now, robot, known, planning.robot_radius, STUCK_DETAIL, once=True):
                return command
            if not self.recovery.is_finished(settings):
                self._stuck.reset()  # try the route again
        self.recovery.end(robot)
        reach = settings.lookahead + 2.0 * self._smoother.braking_distance() + _REACH_MARGIN
        costmap = planning.costmap_around(known, robot, reach)
        # What is too near for the map may hold a robot that cuts a corner.
        lookahead = settings.lookahead * (_HELD_FRACTION if self._stuck.is_held else 1.0)
        x, y = lookahead_point(costmap, robot, planning.points_map, lookahead)
        bearing = wrap_angle(math.atan2(y - robot.y, x - robot.x) - robot.yaw)
        limit = min(self._allowed_speed(robot, planning, costmap), braking_speed_limit(free - _GAP, settings))
        target = velocity_towards(bearing, limit, settings, is_held=self._stuck.is_held)
        return DriveCommand(*self._policy.describe(self._smoother.velocity), target, (float(x), float(y)))

    def _act_without_route(self, now: float, robot: SE2, planning: RoutePlanning, known: GlobalMap) -> DriveCommand:
        """Return what to do without a route: wait for it, recover, or give up with the reason."""
        reason = planning.no_route_reason
        if not planning.is_planned and self.recovery.behavior in (None, RecoveryBehavior.REPLAN):
            return stop_command(DriveState.PLANNING)
        if self._policy.is_waiting_for_route(now, self._settings):
            return stop_command(DriveState.WAITING, f'{DriveState.WAITING.value}: no route around it')
        why = DriveState.UNREACHABLE.value + ('' if reason is None else f': {reason.value}')
        can_help = self.recovery.can_help(reason, planning.replan_count)
        if can_help and (command := self._recover(now, robot, known, planning.robot_radius, why)):
            return command
        tried = self.recovery.summary
        return stop_command(DriveState.UNREACHABLE, f'{why}; tried {tried}' if tried else why)

    def _recover(
        self, now: float, robot: SE2, known: GlobalMap, radius: float, why: str, *, once: bool = False
    ) -> DriveCommand | None:
        """Return the command of a recovery behavior with its reason, None after the last one; see `Recovery.update`."""
        if (velocity := self.recovery.update(now, robot, known, radius, self._settings, once=once)) is None:
            return None
        target = self._turn_in_place(velocity.turn_rate) if velocity.turn_rate != 0.0 else velocity
        return DriveCommand(DriveState.RECOVERING, f'{self.recovery.detail} ({why})', target)

    def _turn_in_place(self, turn_rate: float) -> Velocity:
        """Return a turn rate [rad/s] once the robot has stopped."""
        return Velocity(0.0, turn_rate if abs(self._smoother.velocity.forward) <= _STOPPED_SPEED else 0.0)

    def _allowed_speed(self, robot: SE2, planning: RoutePlanning, costmap: InflatedCostmap) -> float:
        """Return the speed that commands, obstacles and the goal allow [m/s]."""
        distance_max = max(self._settings.lookahead, 2.0 * self._smoother.braking_distance())
        points = planning.points_map
        limit = route_speed_limit(costmap, robot, planning.robot_radius, points, distance_max, self._settings)
        near = points[np.hypot(*(points - (robot.x, robot.y)).T) < distance_max]
        mask_limit = mask_speed_limit(self._global_map.masks, robot, near, self._settings)
        return min(self.command_state.speed_limit, mask_limit, limit)
