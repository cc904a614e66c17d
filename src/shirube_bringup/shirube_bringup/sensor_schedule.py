"""Measurement and publication times of the sensors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

STEP_MS = 20
"""Time step of the simulation [ms]."""


@dataclass(frozen=True)
class SensorSchedule:
    """Schedule of a sensor with a fixed rate.

    Attributes:
        name: name of the sensor.
        period: time between two measurements [ms].
        first: time of the first measurement [ms].
        exposure: time from the stamp of a measurement to the end of its exposure [ms].
        latency: time from the stamp of a measurement to its publication [ms].
    """

    name: str
    period: int
    first: int
    exposure: int
    latency: int

    def indices(self, before: int, until: int, delay: int) -> Iterator[int]:
        """Yield the indices of the measurements whose time plus delay is in (before, until] [ms]."""
        index = max(0, (before - delay - self.first) // self.period + 1)
        while self.first + index * self.period + delay <= until:
            yield index
            index += 1

    def time_ms(self, index: int) -> int:
        """Return the time of a measurement [ms]."""
        return self.first + index * self.period


FLOOR = SensorSchedule('floor', 100, 100, 1, 60)
CEILING = SensorSchedule('ceiling', 80, 120, 8, 60)
STEREO = SensorSchedule('stereo', 1000, 500, 0, 200)
DEPTH = SensorSchedule('depth', 200, 160, 0, 80)
CAMERAS = (FLOOR, CEILING, STEREO, DEPTH)
TILT = SensorSchedule('tilt', 40, 20, 0, 0)
