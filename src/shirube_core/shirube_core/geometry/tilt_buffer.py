"""Buffer of the robot's tilt, for lookup at the stamp of an image."""

from __future__ import annotations

from collections import deque

_KEPT = 2000
"""Buffer length: 10 s of a fast IMU, since images arrive later than their IMU readings."""
_STALE = 0.1
"""Largest difference between the stamps of a tilt and an image [s]; a robot sways faster than this."""


class TiltBuffer:
    """Recent roll and pitch of the base."""

    def __init__(self) -> None:
        """Start without readings."""
        self._readings: deque[tuple[float, tuple[float, float]]] = deque(maxlen=_KEPT)

    def add(self, stamp: float, roll: float, pitch: float) -> None:
        """Add fixed-axis roll and pitch of the base [rad] at a stamp [s]."""
        self._readings.append((stamp, (roll, pitch)))

    def tilt_at(self, stamp: float) -> tuple[float, float] | None:
        """Return the roll and pitch [rad] nearest to a stamp [s], None without a reading within 0.1 s."""
        if not self._readings:
            return None
        nearest, tilt = min(self._readings, key=lambda reading: abs(reading[0] - stamp))
        return tilt if abs(nearest - stamp) <= _STALE else None
