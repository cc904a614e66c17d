"""How the robot leaned at the time of an image."""

from __future__ import annotations

from collections import deque

_KEPT = 2000
"""Ten seconds of a fast imu: images wait longer than readings."""
_STALE = 0.1
"""A robot sways; a tilt that is older than this beside an image says nothing about it [s]."""


class TiltTrail:
    """The tilt of late."""

    def __init__(self) -> None:
        """Begin without readings."""
        self._readings: deque[tuple[float, tuple[float, float]]] = deque(maxlen=_KEPT)

    def add(self, stamp: float, roll: float, pitch: float) -> None:
        """Take fixed-axis roll and pitch of the base at a time [rad, s]."""
        self._readings.append((stamp, (roll, pitch)))

    def tilt_at(self, stamp: float) -> tuple[float, float] | None:
        """Return roll and pitch nearest to a time [rad], None where there is no reading near."""
        if not self._readings:
            return None
        nearest, tilt = min(self._readings, key=lambda reading: abs(reading[0] - stamp))
        return tilt if abs(nearest - stamp) <= _STALE else None
