"""How a lamp moves over the image: a Kalman filter of place and speed, the same along u and along v."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SPEED_SIGMA = 250.0
"""Of a lamp that was just found [px/s]."""
ACCELERATION_SIGMA = 800.0
"""Robots that turn by the spot make lamps far from the middle fast [px/s^2]."""


class ImageMotion:
    """Place and speed of one lamp.

    Attributes:
        stamp: of the last frame [s].
    """

    def __init__(self, stamp: float, place: NDArray[np.float64], sigma: float) -> None:
        """Begin at a place, shape (2,) [px], known to ``sigma`` [px]."""
        self.stamp = stamp
        self._state = np.stack([place, np.zeros(2)])
        self._covariance = np.diag([sigma**2, SPEED_SIGMA**2])

    def expect(self, stamp: float) -> tuple[NDArray[np.float64], float]:
        """Return place, shape (2,), and standard deviation along each axis at a time [px]."""
        state, covariance = self._predicted(stamp)
        return state[0], float(np.sqrt(covariance[0, 0]))

    def coast(self, stamp: float) -> None:
        """Go on to a time without having seen the lamp."""
        self._state, self._covariance = self._predicted(stamp)
        self.stamp = stamp

    def see(self, stamp: float, place: NDArray[np.float64], sigma: float) -> None:
        """Go on to a time at which the lamp is at a place, shape (2,), known to ``sigma`` [px]."""
        self.coast(stamp)
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + sigma**2)
        self._state = self._state + gain[:, None] * (place - self._state[0])
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])

    def _predicted(self, stamp: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        step = max(stamp - self.stamp, 0.0)
        F = np.array([[1.0, step], [0.0, 1.0]])
        G = np.array([0.5 * step**2, step])
        return F @ self._state, F @ self._covariance @ F.T + ACCELERATION_SIGMA**2 * np.outer(G, G)
