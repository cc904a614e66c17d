"""Leads the velocity to the wanted one within the limits of speed, acceleration and jerk, and keeps the curvature.

Both components are measured by what the motors may change in a second, u = (v / a_v, ω / a_ω), so that the limit of
acceleration is 1 and that of jerk J = j_v / a_v for both. The velocity moves along the straight line from u to the
wanted one: the ratio ω / v, the curvature, is kept from rest and down to rest. Time goes in steps of fixed length, for
which the stopping profile below is exact.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.velocity import Velocity

STEP = 0.005
"""Of the limiter's own time [s]."""
_ELAPSED_MAX = 0.2  # a longer pause is taken for this [s]


class VelocityLimiter:
    """A velocity that changes no faster than it may."""

    def __init__(self, settings: DriveSettings) -> None:
        """Begin at rest."""
        self._unit = np.array([settings.max_linear_acceleration, settings.max_angular_acceleration])
        self._fastest = np.array([settings.max_linear_velocity, settings.max_angular_velocity])
        self._jerk = settings.max_linear_jerk / settings.max_linear_acceleration
        self.halt()

    @property
    def velocity(self) -> Velocity:
        """The latest velocity."""
        forward, turn_rate = self._u * self._unit
        return Velocity(float(forward), float(turn_rate))

    def halt(self) -> None:
        """Stand at once, whatever the limits are."""
        self._u = np.zeros(2)
        self._acceleration = np.zeros(2)
        self._left_over = 0.0

    def toward(self, wanted: Velocity, elapsed: float) -> Velocity:
        """Return the velocity after some more time.

        Args:
            wanted: finite; made smaller by one factor where it is too fast.
            elapsed: since the last call [s]; what is no whole step is kept for the next call.
        """
        aim = self._within_speed(wanted) / self._unit
        self._left_over += min(max(elapsed, 0.0), _ELAPSED_MAX)
        count = math.floor(self._left_over / STEP + 1e-9)
        self._left_over = max(0.0, self._left_over - count * STEP)
        for _ in range(count):
            if not self._acceleration.any() and (aim == self._u).all():
                break
            self._step(aim)
        return self.velocity

    def _within_speed(self, wanted: Velocity) -> NDArray[np.float64]:
        velocity = np.array([wanted.forward, wanted.turn_rate])
        return velocity / max(1.0, float(np.max(np.abs(velocity) / self._fastest)))

    def _step(self, aim: NDArray[np.float64]) -> None:
        missing = aim - self._u
        distance = float(np.max(np.abs(missing)))
        best = missing * (min(1.0, float(self._stopping(distance))) / distance) if distance else 0.0 * missing
        reach = self._jerk * STEP
        change = best - self._acceleration
        along = self._acceleration + change * min(1.0, reach / max(float(np.max(np.abs(change))), 1e-300))
        # Where the line bends, a component alone may have to brake earlier than both together would.
        profile = self._stopping(np.abs(missing))
        along = np.where(missing > 0.0, np.minimum(along, profile), np.maximum(along, -profile))
        after = np.clip(along, self._acceleration - reach, self._acceleration + reach)
        self._acceleration = np.clip(after, -1.0, 1.0)
        self._u = self._u + STEP * self._acceleration
        arrived = (np.abs(aim - self._u) < 1e-12) & (np.abs(self._acceleration) <= reach * (1.0 + 1e-9))
        if arrived.all():
            self._u, self._acceleration = aim.copy(), np.zeros(2)

    def _stopping(self, distance: float | NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the greatest acceleration from which 0 is reached, by J·STEP less each step, within a distance.

        With steps of length h: A²/(2J) + A·h/2 = d; below one step's jerk, A·h = d.
        """
        h, jerk = STEP, self._jerk
        steady = jerk * (np.sqrt(0.25 * h * h + 2.0 * np.asarray(distance) / jerk) - 0.5 * h)
        return np.where(np.asarray(distance) <= jerk * h * h, np.asarray(distance) / h, steady)
