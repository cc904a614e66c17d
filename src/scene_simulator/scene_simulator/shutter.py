"""When each row of a frame is exposed: global and rolling shutters."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError


@dataclass(frozen=True)
class Shutter:
    """Timing of a camera.

    The stamp of a frame is the time at which its first row starts to collect light; row r starts
    ``r * row_time`` later.

    Attributes:
        exposure: how long each row collects light [s].
        row_time: how much later each row starts than the row above; 0 for a global shutter [s].
    """

    exposure: float = 0.0005
    row_time: float = 0.0

    def __post_init__(self) -> None:
        """Refuse times that no shutter has.

        Raises:
            SceneError: an exposure that is not positive, or a negative row time.
        """
        if not (0.0 < self.exposure < math.inf and 0.0 <= self.row_time < math.inf):
            raise SceneError(
                f'exposure and row time are {self.exposure} s and {self.row_time} s: '
                'give a positive exposure and a row time of 0 (global shutter) or more'
            )

    def row_middle(self, stamp: float, row: float) -> float:
        """Return the middle of a row's exposure [s]; the row counts from 0 and may be fractional."""
        return stamp + self.row_time * row + 0.5 * self.exposure

    def frame_middle(self, stamp: float, height: int) -> float:
        """Return the middle of the exposure of a frame of ``height`` rows [s]: its pose fits the frame best."""
        return self.row_middle(stamp, 0.5 * (height - 1))

    def frame_end(self, stamp: float, height: int) -> float:
        """Return when the last row of a frame stops collecting light [s]."""
        return stamp + self.row_time * (height - 1) + self.exposure

    def exposure_boundaries(self, stamp: float, rows: slice, count: int) -> NDArray[np.float64]:
        """Return the times that cut each row's exposure into ``count`` equal parts.

        Args:
            stamp: stamp of the frame [s].
            rows: rows from ``start`` to before ``stop``.
            count: number of parts.

        Returns:
            array, shape (rows, count + 1), from the exposure's start to its end [s].
        """
        starts = stamp + self.row_time * np.arange(rows.start, rows.stop, dtype=np.float64)
        return np.asarray(starts[:, None] + self.exposure * np.arange(count + 1) / count)
