"""Inputs, states and output of the drive controller, and the smoother of its velocities."""

import math
from dataclasses import dataclass
from enum import Enum

from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2, wrap_angle

_STEP_MAX = 0.2  # upper bound of the time between two velocities [s]
_REST_TIME = 1.0  # time at rest before an obstacle that fills the view, until the robot turns past it [s]
_TURN_FRACTION = 0.5  # of the maximum turn rate there
_YAW_NOISE = 0.01  # of the pose [rad]


@dataclass(frozen=True)
class Velocity:
    """Velocity of the base: linear along x [m/s] and angular, counterclockwise [rad/s], in the base frame."""

    forward: float = 0.0
    turn_rate: float = 0.0


class VelocitySmoother:
    """Moves the velocity towards a target within the limits of speed, acceleration and jerk.

    Attributes:
        velocity: latest velocity command.
        settings: the limits.
    """

    def __init__(self, settings: DrivingSettings) -> None:
        """Start at rest."""
        self.settings = settings
        self.halt()

    def halt(self) -> None:
        """Restart at rest."""
        self.velocity = Velocity()
        self._acceleration = 0.0

    def step_toward(self, target: Velocity, elapsed: float) -> Velocity:
        """Return the next velocity towards a target, clamped to the limits, some time [s] after the last call."""
        settings = self.settings
        step = min(max(elapsed, 0.0), _STEP_MAX)
        forward = _clamp(target.forward, settings.max_linear_velocity)
        turn_rate = _clamp(target.turn_rate, settings.max_angular_velocity)
        turn_change = settings.max_angular_acceleration * step
        self.velocity = Velocity(
            self._next_speed(forward, step),
            self.velocity.turn_rate + _clamp(turn_rate - self.velocity.turn_rate, turn_change),
        )
        return self.velocity

    def braking_distance(self) -> float:
        """Return the stopping distance if braking starts now [m]."""
        acceleration, jerk = self.settings.max_linear_acceleration, self.settings.max_linear_jerk
        # The speed still grows until the acceleration has dropped to zero.
        delay = (acceleration + max(self._acceleration, 0.0)) / jerk
        speed = max(self.velocity.forward, 0.0)
        top = speed + 0.5 * max(self._acceleration, 0.0) * delay
        return top * delay + 0.5 * top**2 / acceleration

    def _next_speed(self, target: float, step: float) -> float:
        """Change the acceleration so that it reaches 0 together with the target speed."""
        speed, settings = self.velocity.forward, self.settings
        error = target - speed
        limit = min(settings.max_linear_acceleration, math.sqrt(2.0 * settings.max_linear_jerk * abs(error)))
        target_acceleration = math.copysign(limit, error)
        self._acceleration += _clamp(target_acceleration - self._acceleration, settings.max_linear_jerk * step)
        change = self._acceleration * step
        if abs(change) >= abs(error) and change * error >= 0.0:
            self._acceleration = 0.0
            return target
        # The end of braking must not drive the robot the other way.
        if speed >= 0.0:
            return max(speed + change, min(target, 0.0))
        return min(speed + change, max(target, 0.0))


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(value, limit))


class DriveState(Enum):
    """State of the drive controller."""

    IDLE = 'no goal'
    DRIVING = 'driving to the goal'
    LOOKING_AROUND = 'looking around'
    TURNING = 'turning on command of a lamp'
    STOPPED_BY_LAMP = 'stopped on command of a lamp'
    GOAL_REACHED = 'goal reached'
    UNREACHABLE = 'no path to the goal'
    LOST = 'no valid pose'
    MAP_STALE = 'the map is out of date'
    STUCK = 'stuck'
    PLANNING = 'planning'
    RECOVERING = 'recovering'
    GIVING_WAY = 'giving way to a moving obstacle'
    WAITING = 'waiting for a moving obstacle'
    GOING_AROUND = 'going around a moving obstacle'

    @property
    def needs_attention(self) -> bool:
        """Whether the robot is stopped by a problem that somebody must look at."""
        return self in (DriveState.UNREACHABLE, DriveState.LOST, DriveState.MAP_STALE, DriveState.STUCK)


@dataclass(frozen=True)
class DriveCommand:
    """Output of one control cycle.

    Attributes:
        state: state of the controller.
        detail: reason, one line for logs and diagnostics.
        velocity: velocity command; None leaves cmd_vel to other nodes.
        waypoint_map: lookahead point (x, y) [m], None if there is none.
    """

    state: DriveState
    detail: str
    velocity: Velocity | None
    waypoint_map: tuple[float, float] | None = None


def stop_command(state: DriveState, detail: str = '') -> DriveCommand:
    """Return the command to stop, with the state and its detail."""
    return DriveCommand(state, detail or state.value, Velocity())


class DriveInputs:
    """Latest pose and map.

    Attributes:
        pose: the robot's pose in the map; None before the first one and while poses jump.
        pose_stamp: stamp of the pose [s].
        map_stamp: stamp of the latest frame in the map [s].
        near_stamp: stamp of the latest frame that an obstacle fills, too near to be mapped [s].
    """

    def __init__(self) -> None:
        """Start without pose and map."""
        self.pose: SE2 | None = None
        self.pose_stamp = self.map_stamp = self.near_stamp = -math.inf
        # Latest yaw [rad], the sense of the turn to it, and the turn since the map was fresh [rad].
        self._yaw: float | None = None
        self._sense, self._turned = 1.0, 0.0

    def stale(self, now: float, settings: DrivingSettings) -> DriveCommand | None:
        """Return a stop with its reason if pose or map is missing or stale at a time [s], else None."""
        if self.pose is None:
            detail = 'no pose received' if self.pose_stamp == -math.inf else 'the pose jumped'
            return stop_command(DriveState.LOST, f'{DriveState.LOST.value}: {detail}')
        for state, stamp, limit, what in (
            (DriveState.LOST, self.pose_stamp, settings.pose_timeout, 'pose'),
            (DriveState.MAP_STALE, self.map_stamp, settings.map_timeout, 'frame'),
        ):
            if not abs(now - stamp) <= limit:
                if state is DriveState.MAP_STALE and 0.0 <= now - self.near_stamp <= limit < now - stamp - _REST_TIME:
                    self._measure_turn(self.pose.yaw)
                    if self._turned < math.tau:
                        return self._turn_on(settings)
                age = f'the latest {what} is older than {limit:g} s or in the future'
                why = age if stamp > -math.inf else f'no {what} received'
                return stop_command(state, f'{state.value}: {why}')
        self._measure_turn(self.pose.yaw)
        self._turned = 0.0
        return None

    def _measure_turn(self, yaw: float) -> None:
        if self._yaw is None:
            self._yaw = yaw
        turn = wrap_angle(yaw - self._yaw)
        if abs(turn) > _YAW_NOISE:
            self._yaw, self._sense = yaw, math.copysign(1.0, turn)
            self._turned += abs(turn)

    def _turn_on(self, settings: DrivingSettings) -> DriveCommand:
        """Return the turn past an obstacle that fills the view, which the robot would otherwise face for good."""
        detail = f'{DriveState.RECOVERING.value}: turning past an obstacle that fills the view'
        return DriveCommand(
            DriveState.RECOVERING, detail, Velocity(0.0, self._sense * _TURN_FRACTION * settings.max_angular_velocity)
        )
