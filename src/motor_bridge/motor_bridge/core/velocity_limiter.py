"""Moves the velocity towards a target within the limits of speed, acceleration and jerk, and keeps the curvature.

Both components are scaled by their maximum acceleration, u = (v / a_v, ω / a_ω), so that the acceleration limit is 1
and the jerk limit J = j_v / a_v for both. The velocity moves along the straight line from u to the target: the ratio
ω / v, the curvature, is kept from rest and down to rest. Time steps have a fixed length, for which the stopping profile
below is exact. Plain pairs of floats are used for speed, since it runs 200 times a second.
"""

import math

from motor_bridge.core.diff_drive_kinematics import Velocity
from motor_bridge.core.drive_settings import DriveSettings

STEP = 0.005
"""Time step of the limiter [s]."""
_ELAPSED_MAX = 0.2  # upper bound of the time between two calls [s]
_ROUNDING = 1e-12  # rounding error of floats [s]
_Components = tuple[float, float]


class VelocityLimiter:
    """Velocity with limited speed, acceleration and jerk."""

    def __init__(self, settings: DriveSettings) -> None:
        """Start at rest."""
        self._unit = 1.0, 1.0
        self._u: _Components = (0.0, 0.0)
        self._acceleration: _Components = (0.0, 0.0)
        self._unused_time = 0.0
        self.apply_settings(settings)

    def apply_settings(self, settings: DriveSettings) -> None:
        """Use other limits from the present velocity on, which brakes to a lower maximum speed."""
        before, u, acceleration = self._unit, self._u, self._acceleration
        self._unit = settings.max_linear_acceleration, settings.max_angular_acceleration
        self._fastest = (settings.max_linear_velocity / self._unit[0], settings.max_angular_velocity / self._unit[1])
        self._jerk = settings.max_linear_jerk / settings.max_linear_acceleration
        scale = before[0] / self._unit[0], before[1] / self._unit[1]
        self._u = u[0] * scale[0], u[1] * scale[1]
        self._acceleration = acceleration[0] * scale[0], acceleration[1] * scale[1]

    @property
    def velocity(self) -> Velocity:
        """Latest velocity."""
        return Velocity(self._u[0] * self._unit[0], self._u[1] * self._unit[1])

    def halt(self) -> None:
        """Stop at once, without limits."""
        self._u = self._acceleration = (0.0, 0.0)
        self._unused_time = 0.0

    def step_toward(self, target_velocity: Velocity, elapsed: float) -> Velocity:
        """Return the next velocity towards a finite target, which is scaled down by one factor if it is too fast.

        The remainder of a step of the time since the last call [s] is kept for the next call.
        """
        target = self._clamp_speed(target_velocity.forward / self._unit[0], target_velocity.turn_rate / self._unit[1])
        self._unused_time += min(max(elapsed, 0.0), _ELAPSED_MAX)
        count = math.floor(self._unused_time / STEP + 1e-9)
        self._unused_time = max(0.0, self._unused_time - count * STEP)
        for _ in range(count):
            if self._u == target and self._acceleration == (0.0, 0.0):
                break
            self._step(target)
        return self.velocity

    def _clamp_speed(self, *target: float) -> _Components:
        factor = max(1.0, abs(target[0]) / self._fastest[0], abs(target[1]) / self._fastest[1])
        return target[0] / factor, target[1] / factor

    def _step(self, target: _Components) -> None:
        error = target[0] - self._u[0], target[1] - self._u[1]
        distance = max(abs(error[0]), abs(error[1]))
        per_distance = min(1.0, self._stopping_acceleration(distance)) / distance if distance else 0.0
        change = [per_distance * m - a for m, a in zip(error, self._acceleration, strict=True)]
        change_max = self._jerk * STEP
        scale = min(1.0, change_max / max(abs(change[0]), abs(change[1]), 1e-300))
        left, right = (self._limit_component(axis, error[axis], scale * change[axis]) for axis in (0, 1))
        self._acceleration = left, right
        self._u = self._u[0] + STEP * left, self._u[1] + STEP * right
        if max(abs(target[0] - self._u[0]), abs(target[1] - self._u[1])) < _ROUNDING:
            self._u = target

    def _limit_component(self, axis: int, error: float, change: float) -> float:
        """Return the next acceleration of one component.

        After a change of the target, one component may have to brake earlier than both together: before its target and
        before its maximum speed.
        """
        before, speed, fastest = self._acceleration[axis], self._u[axis], self._fastest[axis]
        most = min(1.0, self._stopping_acceleration(max(0.0, fastest - speed)))
        least = -min(1.0, self._stopping_acceleration(max(0.0, fastest + speed)))
        if error >= 0.0:
            most = min(most, self._stopping_acceleration(error))
        if error <= 0.0:
            least = max(least, -self._stopping_acceleration(-error))
        change_max = self._jerk * STEP
        target_velocity = max(least, min(before + change, most))
        return max(before - change_max, min(target_velocity, before + change_max))

    def _stopping_acceleration(self, distance: float) -> float:
        """Return the greatest acceleration that can drop to 0, by J·STEP per step, within a distance.

        With steps of length h, A = n·J·h + r (r < J·h) makes A·h + (A - J·h)·h + … = (n + 1)·A·h - J·h²·n·(n + 1)/2.
        """
        quantum = self._jerk * STEP * STEP
        n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * distance / quantum) - 1.0))
        return (distance / (n + 1) + 0.5 * n * quantum) / STEP
