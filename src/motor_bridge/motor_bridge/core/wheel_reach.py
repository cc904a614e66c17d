"""How far the wheels can have turned since the last good counts, by what was commanded and what they did before."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.velocity import Velocity
from motor_bridge.core.wheel_base import WheelBase

NOISE = 4.0
"""Two counts of a good encoder differ by so much more or less than the wheel turned at most [ticks]."""
_OVERSHOOT = 0.25  # the speed control exceeds speeds by this share at most
_RIPPLE = 3.0  # and by so much, where it counts single ticks [ticks a frame]
_HASTE = 2.0  # nothing but a push turns wheels so many times faster than they may
_COAST = 0.5  # motors without voltage come to rest in this time [s]


class WheelReach:
    """Bounds of the turn of the left and the right wheel, in ticks since the last good counts.

    Every bound is an array, shape (2, 2): the least and the greatest turn (rows) of the left and the right wheel.
    """

    _low: NDArray[np.float64]
    _high: NDArray[np.float64]

    def __init__(self, base: WheelBase, settings: DriveSettings) -> None:
        """Take wheels that stand."""
        self._frame, self._auto_stop = base.frame, settings.auto_stop
        fastest = base.ticks_of(Velocity(settings.max_linear_velocity, -settings.max_angular_velocity))[0]
        self._haste = _HASTE * fastest / base.frame
        self._ripple = _RIPPLE / base.frame
        self._commanded = np.zeros(2)
        self.start((0.0, 0.0))

    def command(self, left: int, right: int) -> None:
        """Take speeds that were sent to the controller [ticks a frame]."""
        self._commanded = np.array([left, right]) / self._frame
        self._low = np.minimum(self._low, self._commanded)
        self._high = np.maximum(self._high, self._commanded)

    def start(self, speeds: tuple[float, float]) -> None:
        """Begin anew at good counts.

        Args:
            speeds: of the wheels there, as measured [ticks/s].
        """
        self._low = np.minimum(speeds, self._commanded)
        self._high = np.maximum(speeds, self._commanded)

    def usual(self, elapsed: float) -> NDArray[np.float64]:
        """Return the bounds while the controller does what it is told.

        Args:
            elapsed: since the last good counts [s].
        """
        return self._bounds(self._low, self._high, elapsed)

    def without_word(self, elapsed: float) -> NDArray[np.float64]:
        """Return the bounds if nobody knows when the controller stopped: its auto-stop ends every motion."""
        time = min(elapsed, self._auto_stop + _COAST)
        return self._bounds(np.minimum(self._low, 0.0), np.maximum(self._high, 0.0), time)

    def after_reset(self) -> NDArray[np.float64]:
        """Return the bounds of the counts themselves if the controller began again: its wheels roll out from 0."""
        return self._bounds(np.minimum(self._low, 0.0), np.maximum(self._high, 0.0), _COAST)

    def pushed(self, elapsed: float) -> float:
        """Return how far a wheel turns at most, whoever turns it [ticks]."""
        return self._haste * elapsed + NOISE

    def _bounds(
        self, low: NDArray[np.float64], high: NDArray[np.float64], elapsed: float
    ) -> NDArray[np.float64]:
        slack = self._ripple * elapsed + NOISE
        least = low * np.where(low < 0.0, 1.0 + _OVERSHOOT, 1.0 - _OVERSHOOT) * elapsed - slack
        most = high * np.where(high > 0.0, 1.0 + _OVERSHOOT, 1.0 - _OVERSHOOT) * elapsed + slack
        return np.array([least, most])


def are_within(turns: tuple[int, int], bounds: NDArray[np.float64]) -> bool:
    """Return whether both wheels' turns [ticks] lie within their bounds."""
    return bool((bounds[0] <= turns).all() and (turns <= bounds[1]).all())


def farthest(bounds: NDArray[np.float64]) -> tuple[float, float]:
    """Return the greatest turn of the left and the right wheel in either direction [ticks]."""
    left, right = np.max(np.abs(bounds), axis=0)
    return math.ceil(left), math.ceil(right)
