"""Where the robot is by the way of its wheels, and how sure that is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.velocity import Velocity
from shirube_geometry import PlanarPose

_SIGMA_START = 1e-4  # [m] and [rad]; a covariance of zeros is refused by most readers


class WheelOdometry:
    """Sums the ways of both wheels.

    Attributes:
        T_odom_base: the pose.
        covariance: shape (3, 3), of (x, y, yaw) [m, m, rad].
    """

    def __init__(self, separation: float, noise: float) -> None:
        """Begin at the origin.

        Args:
            separation: of the wheels [m].
            noise: standard deviation of a wheel's way after one metre [m].
        """
        self._separation, self._noise = separation, noise
        self.reset()

    def reset(self) -> None:
        """Go back to the origin."""
        self.T_odom_base = PlanarPose(0.0, 0.0, 0.0)
        self.covariance: NDArray[np.float64] = _SIGMA_START**2 * np.eye(3)

    def move(self, left: float, right: float) -> None:
        """Add the ways of the wheels [m]: an arc of length (l + r)/2 that turns by (r - l)/b."""
        self._grow(left, right, (self._noise**2 * abs(left), self._noise**2 * abs(right)))
        turn = (right - left) / self._separation
        chord = 0.5 * (left + right) * float(np.sinc(0.5 * turn / np.pi))
        step = PlanarPose(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn)
        self.T_odom_base = self.T_odom_base @ step

    def may_have_moved(self, left: float, right: float) -> None:
        """Grow less sure by ways of the wheels that nobody counted; the pose stays.

        Args:
            left: farthest way of the left wheel, taken for one standard deviation [m].
            right: the same of the right wheel [m].
        """
        self._grow(0.0, 0.0, (left**2, right**2))
        # A turn on the way carries the robot sideways, which the first order does not tell.
        way = 0.5 * (abs(left) + abs(right))
        self.covariance[:2, :2] += way**2 * np.eye(2)

    def velocity_covariance(
        self, left: float, right: float, elapsed: float, tick: float
    ) -> NDArray[np.float64]:
        """Return the covariance, shape (2, 2), of speed and turn rate over some time.

        Args:
            left: way of the left wheel in it [m].
            right: way of the right wheel in it [m].
            elapsed: the time [s], above 0.
            tick: way of one count [m]; each way begins and ends with a rounded count.
        """
        variances = [(self._noise**2 * abs(way) + tick**2 / 6.0) / elapsed**2 for way in (left, right)]
        G = np.array([[0.5, 0.5], [-1.0 / self._separation, 1.0 / self._separation]])
        return G @ np.diag(variances) @ G.T

    def _grow(self, left: float, right: float, variances: tuple[float, float]) -> None:
        """Carry the covariance over a step: F Σ Fᵀ + G diag(σ_l², σ_r²) Gᵀ."""
        forward, turn = 0.5 * (left + right), (right - left) / self._separation
        middle = self.T_odom_base.yaw + 0.5 * turn
        cos, sin = math.cos(middle), math.sin(middle)
        F = np.array([[1.0, 0.0, -forward * sin], [0.0, 1.0, forward * cos], [0.0, 0.0, 1.0]])
        half, inverse = 0.5 * forward / self._separation, 1.0 / self._separation
        G = np.array(
            [
                [0.5 * cos + half * sin, 0.5 * cos - half * sin],
                [0.5 * sin - half * cos, 0.5 * sin + half * cos],
                [-inverse, inverse],
            ]
        )
        covariance = F @ self.covariance @ F.T + G @ np.diag(variances) @ G.T
        self.covariance = 0.5 * (covariance + covariance.T)


def velocity_of_ways(left: float, right: float, elapsed: float, separation: float) -> Velocity:
    """Return the mean velocity of ways of the wheels [m] in some time [s]."""
    return Velocity(0.5 * (left + right) / elapsed, (right - left) / (separation * elapsed))
