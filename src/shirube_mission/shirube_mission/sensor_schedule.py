"""When which sensor measures, and when what it measured is there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

STEP_MS = 20
"""Time of the simulation goes on in such steps [ms]."""


@dataclass(frozen=True)
class SensorRhythm:
    """A sensor that measures at even intervals.

    Attributes:
        name: of the sensor.
        period: between two measurements [ms].
        first: time of the first one [ms].
        exposure: from the time of a measurement until its light is collected [ms].
        latency: from the time of a measurement until it is published [ms].
    """

    name: str
    period: int
    first: int
    exposure: int
    latency: int

    def indices(self, before: int, until: int, delay: int) -> Iterator[int]:
        """Yield the numbers of the measurements for which time plus delay lies in (before, until] [ms]."""
        index = max(0, (before - delay - self.first) // self.period + 1)
        while self.first + index * self.period + delay <= until:
            yield index
            index += 1

    def time_ms(self, index: int) -> int:
        """Return the time of a measurement [ms]."""
        return self.first + index * self.period


FLOOR = SensorRhythm('floor', 100, 100, 1, 60)
CEILING = SensorRhythm('ceiling', 80, 120, 8, 60)
STEREO = SensorRhythm('stereo', 1000, 500, 0, 200)
DEPTH = SensorRhythm('depth', 200, 160, 0, 80)
CAMERAS = (FLOOR, CEILING, STEREO, DEPTH)
TILT = SensorRhythm('tilt', 40, 20, 0, 0)
