"""The collision monitor: the greatest part of a commanded velocity from which the robot stops before any contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.footprint import Footprint
from reward_planner.core.safety.motion_history import MotionHistory
from reward_planner.core.safety.range_frame import RangeFrame
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings, check_limits
from reward_planner.core.safety.stopping_motion import (
    STEP,
    BaseDynamics,
    BaseMotion,
    Obstacles,
    has_contact,
    stopping_paths,
)
from reward_planner.core.safety.watched_source import PredictedObstacles, WatchedSource, chosen
from shirube_core.geometry import SE2

FRACTIONS = np.linspace(1.0, 0.0, 11)
"""Parts of the command that are tried, the greatest first."""
# A robot that stopped for an obstacle drives on when the way has been free for this time [s]; slower, it has stopped.
_RESUME_TIME, _STOPPED_SPEED = 0.3, 0.02
_START_TIME = 2.0  # for this time a robot that stands does not start while somebody may walk into its drive [s]
_CLOCK_BACK = 0.1  # a clock that goes back by more has jumped [s]
_YIELD_MARGIN = 0.12  # clearance to the predicted way of people [m]
_SIGNIFICANT = 2.0  # a velocity counts if it exceeds its standard deviation as many times
_WALKING = 0.2  # a slower cluster does not walk [m/s]


class Action(Enum):
    """What the monitor does with the command."""

    DRIVE = 'drive'
    SLOW_DOWN = 'slow down'
    APPROACH = 'approach'
    YIELD = 'give way'
    STOP = 'stop'
    FAULT = 'fault'


@dataclass(frozen=True)
class Decision:
    """The velocity to publish: forward [m/s] and turn rate [rad/s], the action, and its reason in one line."""

    forward: float
    turn_rate: float
    action: Action
    reason: str
    source: str = ''
    fraction: float = 0.0


class CollisionMonitor:
    """Limits commands so that the robot stands before it touches anything that its sensors saw.

    Attributes:
        footprint: outline of the robot.
        sources: sensors by name.
        path, slow_path: way to a stop at the command, and that of the slow-down zone, shape (n, 3), in the base frame.
    """

    def __init__(self, settings: CollisionMonitorSettings, sources: Mapping[str, SourceSettings]) -> None:
        """Start without commands and ranges: the robot stops.

        Raises:
            RewardPlannerError: no source, contradictory limits, or an invalid footprint or exclusion zone.
        """
        if not sources:
            raise RewardPlannerError('sources is empty; name at least one range sensor')
        if len(settings.exclusion_zones) % 6:
            raise RewardPlannerError('exclusion_zones must have six numbers for each box; complete the last one')
        zones = np.array(settings.exclusion_zones, dtype=np.float64).reshape(-1, 6)
        if (zones[:, :3] >= zones[:, 3:]).any():
            raise RewardPlannerError(
                'exclusion_zones has a box whose lowest corner is not below its greatest; exchange them'
            )
        for name, source in sources.items():
            check_limits(name, source)
        self._settings, self._source_settings = settings, dict(sources)
        self.footprint = Footprint(settings.footprint, settings.robot_radius)
        self._base = BaseDynamics(settings.latency, settings.deceleration, settings.angular_deceleration)
        self._now = -math.inf
        self.reset()

    def reset(self) -> None:
        """Forget commands, ranges and motion: the robot stops until all are fresh again."""
        zones = np.array(self._settings.exclusion_zones, dtype=np.float64).reshape(-1, 6)
        self.sources = {
            name: WatchedSource(name, source, zones, self._settings) for name, source in self._source_settings.items()
        }
        self._motion = MotionHistory(self._base)
        self._command: tuple[float, float, float] | None = None
        self._command_fault = 'no cmd_vel_in yet'
        self._stopped = -math.inf, Action.STOP, ''
        self._idle = -math.inf  # when the robot last moved, or was not to drive [s]
        self.path = self.slow_path = np.zeros((1, 3))

    def add_command(self, now: float, forward: float, turn_rate: float) -> None:
        """Take a commanded velocity [m/s, rad/s] now [s].

        Raises:
            RewardPlannerError: a number is not finite; the robot stops.
        """
        if not math.isfinite(forward) or not math.isfinite(turn_rate):
            self.refuse_command('cmd_vel_in is not finite; check its publisher')
        if self._command is None:
            self._idle = now
        self._command = (now, forward, turn_rate)

    def refuse_command(self, reason: str) -> NoReturn:
        """Stop the robot until the next valid command.

        Raises:
            RewardPlannerError: always, with the reason in one line.
        """
        self._command, self._command_fault = None, reason
        raise RewardPlannerError(reason)

    def add_odometry(self, stamp: float, pose: SE2) -> None:
        """Take a pose of the base in the frame of the odometry at a stamp [s]."""
        self._motion.add_odometry(stamp, pose)

    def add_frame(self, name: str, stamp: float, now: float, frame: RangeFrame) -> None:
        """Take a measurement of a source with its stamp [s]; compensates the motion of the robot since then.

        Raises:
            RewardPlannerError: the measurement has no ray or an invalid stamp; the robot stops.
        """
        self._advance(now)
        self.sources[name].add(stamp, now, frame, self._motion.pose_at(stamp))

    def invalidate(self, name: str, reason: str) -> None:
        """Stop the robot until the next valid measurement of a source, for a reason in one line."""
        self.sources[name].invalidate(reason)

    def decide(self, now: float) -> Decision:
        """Return the velocity to publish now [s]."""
        # 1. The clock: after it went back, nothing is fresh.
        if now < self._now - _CLOCK_BACK:
            self._now = now
            self.reset()
            return self._give(now, Decision(0.0, 0.0, Action.FAULT, 'the clock went back; all is forgotten'))
        self._advance(now)
        # 2. The command and every source must be fresh; what is not is named.
        fault = self._fault(now)
        if fault is not None or self._command is None:
            return self._give(now, fault or Decision(0.0, 0.0, Action.FAULT, self._command_fault))
        command = self._command[1:]
        # 3. All obstacles, where they are now in the base frame: the robot moved since they were measured.
        T_odom_base = self._motion.pose_at(now)
        if T_odom_base is None:
            return self._give(now, Decision(0.0, 0.0, Action.FAULT, 'no odometry at this time; check odom'))
        # 4. Points within the footprint are parts of the robot or a wrong mount: it stops and names them.
        for source in self.sources.values():
            count = source.count_inside(self.footprint, T_odom_base)
            if count:
                reason = f'{source.name}: {count} cells within the footprint; correct the mount or set exclusion_zones'
                return self._give(now, Decision(0.0, 0.0, Action.STOP, reason, source.name))
        return self._give(now, self._limit(now, command, T_odom_base))

    def _limit(self, now: float, command: tuple[float, float], T_odom_base: SE2) -> Decision:
        """Return the most restrictive of approach, giving way and the slow-down zone."""
        motion = self._motion.motion(now)
        # 5. The way to a stop of each part of the command: latency, one period, then braking.
        paths = stopping_paths(motion, command, FRACTIONS, 1.0 / self._settings.rate, self._base)
        self.path = paths[0]
        moves = max(abs(motion.forward), abs(motion.given_forward)) > _STOPPED_SPEED
        starts = not moves and command[0] != 0.0
        if not starts:
            self._idle = now
        caution = 0.0 if starts and now - self._idle < _START_TIME else self._settings.slow_fraction
        # A round robot that turns in place sweeps nothing: whoever is near, it may turn away.
        if not (moves or self._settings.footprint or abs(command[0]) >= _STOPPED_SPEED):
            return Decision(0.0, command[1], Action.DRIVE, _REASONS[Action.DRIVE], fraction=1.0)
        best = (1.0, Action.DRIVE, '')
        for source in self.sources.values():
            source.drop_met(now, self.footprint, T_odom_base)
            found = source.obstacles(now, T_odom_base)
            # 6. Approach: the robot stands before a disc that holds each obstacle meets its footprint.
            best = min(best, self._approach(source.name, paths, found.all), key=_fraction)
            # 7. Giving way: it waits for those whose way it would cross, and is slow while that is uncertain.
            best = min(best, self._yield(source.name, motion, command, found, caution), key=_fraction)
            # 8. Slow-down zone: along the commanded path for some time, and what may turn out to walk.
            best = min(best, self._slow_down(source.name, command, found.all), key=_fraction)
            limit = max(self._approach(source.name, paths, found.unsure)[0], self._settings.slow_fraction)
            best = min(best, (limit, Action.SLOW_DOWN, source.name), key=_fraction)
        # 9. The most restrictive wins.
        fraction, action, source_name = best
        if fraction == 0.0 and any(command):
            action = Action.STOP if action is not Action.YIELD else action
            if action is Action.YIELD or abs(motion.forward) < _STOPPED_SPEED:
                self._stopped = now, action, source_name
        elif now - self._stopped[0] < _RESUME_TIME:
            fraction, (_, action, source_name) = 0.0, self._stopped
        reason = f'{source_name}: {_REASONS[action]}' if source_name else _REASONS[action]
        return Decision(fraction * command[0], fraction * command[1], action, reason, source_name, fraction)

    def _give(self, now: float, decision: Decision) -> Decision:
        # 10. What is published now moves the base after its latency.
        self._motion.give(now, decision.forward, decision.turn_rate)
        return decision

    def _advance(self, now: float) -> None:
        self._now = max(self._now, now)
        if self._motion.advance(now):
            for source in self.sources.values():
                source.forget_places()  # they were in another frame

    def _fault(self, now: float) -> Decision | None:
        if self._command is not None and now - self._command[0] > self._settings.command_timeout:
            self._command_fault = 'cmd_vel_in is silent; check the node that commands'
            self._command = None
        for source in self.sources.values():
            fault = source.fault(now)
            if fault is not None:
                return Decision(0.0, 0.0, Action.FAULT, f'{source.name}: {fault}', source.name)
        return None

    def _approach(self, name: str, paths: list[NDArray[np.float64]], obstacles: Obstacles) -> _Limit:
        near = _within(obstacles, self.footprint.radius, paths[0], 0.0)
        for fraction, path in zip(FRACTIONS.tolist(), paths, strict=True):
            if not has_contact(path, self.footprint.corners, self.footprint.radius, near):
                return fraction, Action.APPROACH, name
        return 0.0, Action.STOP, name

    def _yield(
        self, name: str, motion: BaseMotion, command: tuple[float, float], found: PredictedObstacles, caution: float
    ) -> _Limit:
        """Stop for people whom the commanded drive would meet: the earlier it stops, the less it is in their way.

        As long as it is not certain where somebody walks, ``caution`` is the part of the command if the drive may meet
        him.
        """
        settings, speed = self._settings, np.hypot(*found.all.velocity.T)
        certain = found.walks & (speed > _WALKING) & (speed > _SIGNIFICANT * np.nan_to_num(found.sigma, nan=np.inf))
        may_walk = found.in_view & (found.all.growth > 0.0) & ~certain
        if not (certain | may_walk).any():
            return 1.0, Action.YIELD, name
        drive = stopping_paths(motion, command, FRACTIONS[:1], settings.yield_time, self._base)[0]
        drive = drive[: int(settings.yield_time / STEP)]
        people = found.all._replace(growth=0.0 * speed, radius=np.full(len(speed), _YIELD_MARGIN))
        if has_contact(drive, self.footprint.corners, self.footprint.radius, chosen(people, certain)):
            return 0.0, Action.YIELD, name
        spread = np.minimum(np.nan_to_num(found.sigma, nan=np.inf), settings.obstacle_speed)
        people = people._replace(growth=spread)
        is_met = has_contact(drive, self.footprint.corners, self.footprint.radius, chosen(people, may_walk))
        return (caution if is_met else 1.0), Action.YIELD, name

    def _slow_down(self, name: str, command: tuple[float, float], obstacles: Obstacles) -> _Limit:
        settings = self._settings
        motion = BaseMotion(command[0], command[1], command[0], command[1])
        steady = self._base._replace(latency=settings.slow_time, deceleration=1e9, angular_deceleration=1e9)
        path = stopping_paths(motion, (0.0, 0.0), FRACTIONS[-1:], 0.0, steady)[0]
        self.slow_path = path
        near = _within(obstacles, self.footprint.radius, path, settings.slow_margin)
        near = near._replace(radius=near.radius + settings.slow_margin, growth=0.0 * near.growth)
        is_met = has_contact(path, self.footprint.corners, self.footprint.radius, near)
        return (settings.slow_fraction if is_met else 1.0), Action.SLOW_DOWN, name


_Limit = tuple[float, Action, str]
_REASONS = {
    Action.DRIVE: 'free',
    Action.SLOW_DOWN: 'obstacle in the slow-down zone',
    Action.APPROACH: 'obstacle within the stopping distance',
    Action.YIELD: 'gives way to somebody who walks',
    Action.STOP: 'obstacle in the stop zone',
}


def _fraction(limit: _Limit) -> float:
    return limit[0]


def _within(obstacles: Obstacles, reach: float, path: NDArray[np.float64], margin: float) -> Obstacles:
    """Return the obstacles that can meet the footprint on a path or a shorter one."""
    time = STEP * len(path)
    length = float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum())
    speed = obstacles.growth + np.hypot(*obstacles.velocity.T)
    gap = np.hypot(*obstacles.xy.T) - obstacles.radius - speed * time
    return chosen(obstacles, gap < reach + length + margin + 0.05)
