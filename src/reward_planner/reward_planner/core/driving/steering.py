"""Velocities that lead a robot with two driven wheels to a point or a heading."""

from __future__ import annotations

import math

from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.velocity_ramp import Velocity

_STEER_TIME = 0.4  # deviations of the heading are made up for in about this time [s]
_BRAKE_SHARE = 0.5  # of the acceleration is used to stop in time
_RESPONSE = 0.15  # from a pose, a little old, until the wheels do what was made of it [s]
_DRIVE_WITHIN = 0.6  # with a larger deviation the robot turns on the spot [rad]
_SLOWEST_SHARE = 0.25  # of the greatest speed, close to obstacles
_SLOWEST = 0.1  # fast enough there for any robot [m/s]


def turn_by(angle: float, settings: DrivingSettings) -> float:
    """Return the turn rate for a turn that is left [rad/s]; it ends without overshoot."""
    brake = math.sqrt(2.0 * _BRAKE_SHARE * settings.max_angular_acceleration * abs(angle))
    rate = min(brake, abs(angle) / _STEER_TIME, settings.max_angular_velocity)
    return math.copysign(rate, angle)


def drive_towards(bearing: float, speed: float, settings: DrivingSettings) -> Velocity:
    """Return the velocity towards a point.

    Args:
        bearing: of the point, from straight ahead, counterclockwise [rad].
        speed: to be used on a straight way [m/s].
        settings: limits.
    """
    forward = speed * max(0.0, 1.0 - abs(bearing) / _DRIVE_WITHIN)
    return Velocity(forward, turn_by(bearing, settings))


def speed_for_stop(distance: float, settings: DrivingSettings) -> float:
    """Return the speed from which the robot can stop within a distance [m]: [m/s]."""
    acceleration = _BRAKE_SHARE * settings.max_linear_acceleration
    delay = settings.max_linear_acceleration / settings.max_linear_jerk + _RESPONSE
    # v delay + v^2 / (2 a) = distance
    return acceleration * (math.sqrt(delay**2 + 2.0 * max(distance, 0.0) / acceleration) - delay)


def speed_near_obstacles(gap: float, settings: DrivingSettings) -> float:
    """Return the speed that is allowed so near to obstacles [m/s].

    Args:
        gap: from the rim of the robot to the nearest obstacle [m]; from ``slow_distance`` on the robot may go fast.
        settings: limits.
    """
    fastest = settings.max_linear_velocity
    slowest = min(_SLOWEST, _SLOWEST_SHARE * fastest)
    return max(slowest, fastest * min(1.0, gap / settings.slow_distance))
