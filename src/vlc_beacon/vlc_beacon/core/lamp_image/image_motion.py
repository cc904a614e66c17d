"""Constant-velocity Kalman filter of a lamp's image position, with equal noise along u and v."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SPEED_SIGMA = 250.0
"""Initial standard deviation of the image velocity [px/s]."""
ACCELERATION_SIGMA = 800.0
"""Process noise [px/s^2]; lamps far from the image centre move fast when the robot turns in place."""


class ImageMotion:
    """Position and velocity of one lamp in the image.

    Attributes:
        stamp: time of the state [s].
    """

    def __init__(self, stamp: float, position: NDArray[np.float64], sigma: float) -> None:
        """Initialize with a position, shape (2,) [px], and its standard deviation ``sigma`` [px]."""
        self.stamp = stamp
        self._state = np.stack([position, np.zeros(2)])
        self._covariance = np.diag([sigma**2, SPEED_SIGMA**2])

    def predict(self, stamp: float) -> tuple[NDArray[np.float64], float]:
        """Return the predicted position, shape (2,), and its standard deviation per axis at a time [px]."""
        state, covariance = self._predict_state(stamp)
        return state[0], float(np.sqrt(covariance[0, 0]))

    def coast(self, stamp: float) -> None:
        """Advance the state to a time without a measurement."""
        self._state, self._covariance = self._predict_state(stamp)
        self.stamp = stamp

    def update(self, stamp: float, position: NDArray[np.float64], sigma: float) -> None:
        """Advance the state to a time and update it with a measured position, shape (2,), of ``sigma`` [px]."""
        self.coast(stamp)
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + sigma**2)
        self._state = self._state + gain[:, None] * (position - self._state[0])
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])

    def _predict_state(self, stamp: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        step = max(stamp - self.stamp, 0.0)
        F = np.array([[1.0, step], [0.0, 1.0]])
        G = np.array([0.5 * step**2, step])
        return F @ self._state, F @ self._covariance @ F.T + ACCELERATION_SIGMA**2 * np.outer(G, G)
