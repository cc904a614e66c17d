"""Executes lamp commands (slow, stop, turn) in closed loop on the robot's pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_core.geometry import SE2, wrap_angle
from shirube_core.settings import setting, tunable
from vlc_beacon.core.packet.command_packet import Operation


@tunable()
@dataclass(frozen=True)
class DriveSettings:
    """Motion parameters used when `drive` is true."""

    cruise_speed: float = setting(0.3, 'forward speed until a command changes it, and after resume', 'm/s', (0.0, 10.0))
    acceleration: float = setting(0.5, 'maximum forward acceleration and deceleration', 'm/s^2', (0.01, 10.0))
    turn_rate_max: float = setting(1.0, 'maximum yaw rate', 'rad/s', (0.05, 10.0))
    turn_acceleration: float = setting(2.0, 'maximum yaw acceleration', 'rad/s^2', (0.05, 50.0))
    turn_tolerance: float = setting(
        math.radians(1.0), 'a turn is complete when the remaining angle is below this', 'rad', (0.001, 0.3)
    )
    line_distance: float = setting(0.5, 'lookahead distance along the reference line', 'm', (0.05, 10.0))
    pose_timeout: float = setting(0.5, 'maximum age of a pose; without a newer one the robot brakes', 's', (0.02, 10.0))


@dataclass(frozen=True)
class Velocity:
    """Forward speed [m/s] and yaw rate [rad/s] of the base, counterclockwise."""

    forward: float = 0.0
    turn_rate: float = 0.0

    @property
    def is_zero(self) -> bool:
        """Whether both components are zero."""
        return self.forward == 0.0 and self.turn_rate == 0.0

    def step_toward(self, target: Velocity, forward_step: float, turn_step: float) -> Velocity:
        """Return this velocity moved towards a target by at most one step [m/s] and [rad/s]."""
        return Velocity(
            _step_toward(self.forward, target.forward, forward_step),
            _step_toward(self.turn_rate, target.turn_rate, turn_step),
        )


def _step_toward(value: float, target: float, step: float) -> float:
    return target if abs(target - value) <= step else value + math.copysign(step, target - value)


class ReferenceLine:
    """A line through a position, and the robot's heading error relative to it.

    The heading is unwrapped, so that a turn by 270 degrees is made in the commanded direction.

    Args:
        start: initial pose of the robot in the map; it defines the line.
    """

    def __init__(self, start: SE2) -> None:
        self._origin = (start.x, start.y)
        self._pose = start
        self._yaw = self._heading = start.yaw

    def update_pose(self, T_map_base: SE2) -> None:
        """Update the robot's pose."""
        self._yaw += wrap_angle(T_map_base.yaw - self._yaw)
        self._pose = T_map_base

    def rotate(self, angle: float) -> None:
        """Rotate the line [rad]; its origin is set when the turn is complete, see `restart_at_robot`."""
        self._heading += angle

    def restart_at_robot(self) -> None:
        """Move the origin of the line to the robot's position."""
        self._origin = (self._pose.x, self._pose.y)

    @property
    def remaining_turn(self) -> float:
        """Heading error: angle from the robot's heading to the line [rad]."""
        return self._heading - self._yaw

    def steering_angle(self, distance: float) -> float:
        """Return the angle to the heading that leads back to the line within a lookahead distance [m] [rad]."""
        dx, dy = self._pose.x - self._origin[0], self._pose.y - self._origin[1]
        cross_track_error = math.cos(self._heading) * dy - math.sin(self._heading) * dx
        return wrap_angle(self.remaining_turn - math.atan2(cross_track_error, distance))


# Time constant of the heading controller [s].
_STEERING_TIME = 0.4
# Braking of a turn begins earlier than the acceleration limit requires, because poses are delayed.
_TURN_BRAKE_FACTOR = 0.5


class CommandExecutor:
    """Converts accepted commands and poses to velocities.

    The robot follows a straight reference line through its first pose. A turn is executed in place: brake, turn, follow
    the new line. Without a fresh pose the robot brakes; once stopped, no velocity is published, so that another
    controller or the `cmd_vel` timeout of the motors takes over. The next pose then starts a new line, and an
    interrupted turn is not resumed.

    Args:
        settings: drive parameters.
        speed_limit: upper bound of the forward speed [m/s].

    Attributes:
        is_stopped: whether a stop command is active, not yet followed by resume.
    """

    def __init__(self, settings: DriveSettings, speed_limit: float) -> None:
        self._settings = settings
        self._speed_limit = speed_limit
        self._speed = min(settings.cruise_speed, speed_limit)
        self.is_stopped = False
        self._is_turning = False
        self._is_released = False
        self._line: ReferenceLine | None = None
        self._pose_stamp = -math.inf
        self._last: tuple[float, Velocity] | None = None

    def apply_settings(self, settings: DriveSettings, speed_limit: float) -> None:
        """Use other drive parameters; the speed is the cruise speed until the next command."""
        self._settings, self._speed_limit = settings, speed_limit
        self._speed = min(settings.cruise_speed, speed_limit)

    def halt(self) -> None:
        """Restart at rest with the next pose; a stop command stays in effect."""
        self._line, self._last, self._is_turning = None, None, False

    def execute(self, operation: Operation, value: float) -> None:
        """Execute an accepted command; see `Operation`. A turn before the first pose is ignored."""
        match operation:
            case Operation.STOP:
                self.is_stopped = True
            case Operation.RESUME:
                self.is_stopped = False
                self._speed = min(self._settings.cruise_speed, self._speed_limit)
            case Operation.SLOW:
                self._speed = min(self._speed, value)
            case Operation.SPEED_UP:
                self._speed = min(value, self._speed_limit)
            case Operation.TURN if self._line is not None:
                self._line.rotate(value)
                self._is_turning = True

    def update_pose(self, stamp: float, T_map_base: SE2) -> None:
        """Update the robot's pose in the map at a time [s]; the first pose, also after a stop, defines the line."""
        if self._line is None or self._is_released:
            self._line = ReferenceLine(T_map_base)
            self._is_turning = self._is_released = False
        self._line.update_pose(T_map_base)
        self._pose_stamp = stamp

    def velocity(self, stamp: float) -> Velocity | None:
        """Return the velocity at a time [s], called periodically; None to release the motors to other publishers."""
        before, last = self._last or (stamp, Velocity())
        step = min(max(stamp - before, 0.0), self._settings.pose_timeout)
        target = self._target_velocity(stamp, last)
        given = target or Velocity()
        settings = self._settings
        velocity = last.step_toward(given, settings.acceleration * step, settings.turn_acceleration * step)
        self._last = (stamp, velocity)
        # Publish zero once; otherwise the motors would keep the last nonzero velocity until their timeout.
        self._is_released = target is None and last.is_zero
        return None if self._is_released else velocity

    def _target_velocity(self, stamp: float, last: Velocity) -> Velocity | None:
        line, settings = self._line, self._settings
        if line is None or abs(stamp - self._pose_stamp) > settings.pose_timeout:
            return None
        if self.is_stopped:
            return Velocity()
        if self._is_turning:
            return self._turn_velocity(line, last)
        angle = line.steering_angle(settings.line_distance)
        return Velocity(self._speed, self._clamp_turn_rate(angle / _STEERING_TIME))

    def _turn_velocity(self, line: ReferenceLine, last: Velocity) -> Velocity:
        left = line.remaining_turn
        if abs(left) <= self._settings.turn_tolerance and last.forward == 0.0:
            self._is_turning = False
            line.restart_at_robot()
            return Velocity()
        if last.forward > 0.0:
            return Velocity()
        fastest = math.sqrt(2.0 * _TURN_BRAKE_FACTOR * self._settings.turn_acceleration * abs(left))
        return Velocity(0.0, self._clamp_turn_rate(math.copysign(min(fastest, abs(left) / _STEERING_TIME), left)))

    def _clamp_turn_rate(self, turn_rate: float) -> float:
        return max(-self._settings.turn_rate_max, min(turn_rate, self._settings.turn_rate_max))
