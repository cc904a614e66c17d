"""Velocity smoother of a differential drive robot: limits of speed, acceleration and jerk."""

import math
from dataclasses import dataclass

from reward_planner.core.settings import DrivingSettings

_STEP_MAX = 0.2  # upper bound of the time between two velocities [s]


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
