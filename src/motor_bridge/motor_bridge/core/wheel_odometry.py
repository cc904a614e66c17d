"""Wheel odometry: pose and covariance from wheel distances."""

import math

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.diff_drive_kinematics import Velocity
from shirube_core.geometry import SE2

_SIGMA_START = 1e-4  # [m] and [rad]; many programs reject a zero covariance


class WheelOdometry:
    """Integrates the distances of both wheels.

    Attributes:
        T_odom_base: pose of the base in the odometry frame.
        covariance: covariance of (x, y, yaw) [m, m, rad], shape (3, 3).
    """

    def __init__(self, separation: float, noise: float) -> None:
        """Start at the origin; ``noise`` is the standard deviation of a wheel distance after one metre [m]."""
        self._separation, self._noise = separation, noise
        self.reset()

    def reset(self) -> None:
        """Reset the pose to the origin."""
        self.T_odom_base = SE2(0.0, 0.0, 0.0)
        self.covariance: NDArray[np.float64] = _SIGMA_START**2 * np.eye(3)

    def move(self, left: float, right: float) -> None:
        """Add wheel distances [m]: an arc of length (l + r)/2 that turns by (r - l)/b."""
        self._propagate_covariance(left, right, (self._noise**2 * abs(left), self._noise**2 * abs(right)))
        turn = (right - left) / self._separation
        self.T_odom_base = self.T_odom_base @ SE2.exp(0.5 * (left + right), 0.0, turn)

    def add_uncounted_motion(self, left: float, right: float) -> None:
        """Inflate the covariance by the greatest uncounted distances of the wheels, one standard deviation each [m]."""
        self._propagate_covariance(0.0, 0.0, (left**2, right**2))
        # Turns during the motion move the robot sideways, which the first order neglects.
        distance = 0.5 * (abs(left) + abs(right))
        self.covariance[:2, :2] += distance**2 * np.eye(2)

    def velocity_covariance(self, left: float, right: float, elapsed: float, tick: float) -> NDArray[np.float64]:
        """Return the covariance of linear speed and turn rate, shape (2, 2), from wheel distances [m] in some time [s].

        Each distance has two rounded counts; ``tick`` is the distance per tick [m].
        """
        variances = [(self._noise**2 * abs(distance) + tick**2 / 6.0) / elapsed**2 for distance in (left, right)]
        G = np.array([[0.5, 0.5], [-1.0 / self._separation, 1.0 / self._separation]])
        return G @ np.diag(variances) @ G.T

    def _propagate_covariance(self, left: float, right: float, variances: tuple[float, float]) -> None:
        """Propagate the covariance over a step: F Σ Fᵀ + G diag(σ_l², σ_r²) Gᵀ."""
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


def velocity_from_distances(left: float, right: float, elapsed: float, separation: float) -> Velocity:
    """Return the mean velocity of wheel distances [m] in some time [s]."""
    return Velocity(0.5 * (left + right) / elapsed, (right - left) / (separation * elapsed))
