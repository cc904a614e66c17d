"""Steering and speed limits of a differential drive robot."""

from __future__ import annotations

import math

from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.velocity_smoother import Velocity

_HEADING_TIME_CONSTANT = 0.4  # time constant of the heading error [s]
_BRAKE_FRACTION = 0.5  # fraction of the maximum acceleration that is planned for braking
_RESPONSE_TIME = 0.15  # latency from a pose to the motion of the wheels [s]
_DRIVE_BEARING_MAX = 0.6  # above this bearing the robot turns in place [rad]
_SLOWEST_FRACTION = 0.25  # minimum speed near obstacles, fraction of the maximum speed
_SLOWEST = 0.1  # upper bound of the minimum speed near obstacles [m/s]


def turn_rate_for_angle(angle: float, settings: DrivingSettings) -> float:
    """Return the turn rate for a remaining angle [rad/s]; it decelerates without overshoot."""
    brake = math.sqrt(2.0 * _BRAKE_FRACTION * settings.max_angular_acceleration * abs(angle))
    rate = min(brake, abs(angle) / _HEADING_TIME_CONSTANT, settings.max_angular_velocity)
    return math.copysign(rate, angle)


def velocity_towards(bearing: float, speed: float, settings: DrivingSettings) -> Velocity:
    """Return the velocity towards a point.

    Args:
        bearing: bearing of the point, counterclockwise from straight ahead [rad].
        speed: speed at zero bearing [m/s].
        settings: velocity and acceleration limits.
    """
    forward = speed * max(0.0, 1.0 - abs(bearing) / _DRIVE_BEARING_MAX)
    return Velocity(forward, turn_rate_for_angle(bearing, settings))


def braking_speed_limit(distance: float, settings: DrivingSettings) -> float:
    """Return the maximum speed from which the robot can stop within a distance [m]: [m/s]."""
    acceleration = _BRAKE_FRACTION * settings.max_linear_acceleration
    delay = settings.max_linear_acceleration / settings.max_linear_jerk + _RESPONSE_TIME
    # Solve v delay + v^2 / (2 a) = distance for v.
    return acceleration * (math.sqrt(delay**2 + 2.0 * max(distance, 0.0) / acceleration) - delay)


def obstacle_speed_limit(gap: float, settings: DrivingSettings) -> float:
    """Return the maximum speed near obstacles [m/s].

    Args:
        gap: distance from the robot's edge to the nearest obstacle [m]; no limit from ``slow_distance`` on.
        settings: velocity and acceleration limits.
    """
    fastest = settings.max_linear_velocity
    slowest = min(_SLOWEST, _SLOWEST_FRACTION * fastest)
    return max(slowest, fastest * min(1.0, gap / settings.slow_distance))
