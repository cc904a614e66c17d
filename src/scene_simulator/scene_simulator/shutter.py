"""When each row of a frame is exposed: global and rolling shutters."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.scene_error import SceneError


@dataclass(frozen=True)
class Shutter:
    """Timing of a camera.

    The stamp of a frame is the middle of its exposure: the middle of the window in which its middle row
    (between rows if their number is even) collects light. That is the instant whose pose fits the whole image best.

    Attributes:
        exposure: how long each row collects light [s].
        row_time: how much later each row starts than the row above; 0 for a global shutter [s].
        frame_period: time between the stamps of two frames [s].
    """

    exposure: float = 0.0005
    row_time: float = 0.0
    frame_period: float = 1.0 / 60.0

    def __post_init__(self) -> None:
        """Refuse times that no shutter has.

        Raises:
            SceneError: an exposure or period that is not positive, or a negative row time.
        """
        times = (self.exposure, self.row_time, self.frame_period)
        if not all(map(math.isfinite, times)) or self.row_time < 0.0 or min(times[::2]) <= 0.0:
            raise SceneError(
                f'exposure, row time and frame period are {times} s: give positive numbers (row time 0: global)'
            )

    def first_row_start(self, stamp: float, height: int) -> float:
        """Return when the first row of a frame of ``height`` rows starts to collect light [s]."""
        return stamp - 0.5 * self.exposure - 0.5 * (height - 1) * self.row_time

    def stamp_from_first_row_start(self, start: float, height: int) -> float:
        """Return the stamp of a frame whose first row starts to collect light at a time [s]."""
        return start + 0.5 * self.exposure + 0.5 * (height - 1) * self.row_time

    def row_starts(self, stamp: float, height: int) -> NDArray[np.float64]:
        """Return when each row starts to collect light, shape (height,) [s]."""
        return self.first_row_start(stamp, height) + self.row_time * np.arange(height)

    def frame_gap(self, height: int) -> float:
        """Return how long no row starts between the last row of a frame and the first of the next [s]."""
        return self.frame_period - height * self.row_time
