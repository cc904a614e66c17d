"""Row samples of a lamp under a rolling shutter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class LampRows:
    """Row brightness of a lamp in frames in which it covers the same number of rows; usually one frame.

    Attributes:
        stamps: start of exposure of image row 0, shape (n,) [s].
        first_rows: first row of the lamp in each image, shape (n,).
        brightness: mean of each row over the lamp, shape (n, rows), any unit.
        row_time: line time between the starts of two rows [s].
        exposure: exposure of a row [s].
    """

    stamps: NDArray[np.float64]
    first_rows: NDArray[np.int64]
    brightness: NDArray[np.float64]
    row_time: float
    exposure: float

    @property
    def centre_times(self) -> NDArray[np.float64]:
        """Times at which the middle of the lamp was exposed, shape (n,) [s]."""
        rows = self.first_rows + 0.5 * (self.brightness.shape[1] - 1)
        return self.stamps + rows * self.row_time + 0.5 * self.exposure

    def drop_invalid_frames(self) -> LampRows:
        """Return the frames in which all rows are finite."""
        kept = np.isfinite(self.brightness).all(axis=1)
        if kept.all():
            return self
        return LampRows(
            self.stamps[kept], self.first_rows[kept], self.brightness[kept], self.row_time, self.exposure
        )


def rows_from_frame(
    stamp: float, first_row: int, brightness: ArrayLike, row_time: float, exposure: float
) -> LampRows:
    """Return the rows of a lamp in one frame; brightness has shape (rows,), other arguments as in `LampRows`."""
    seen = np.asarray(brightness, float)[None]
    return LampRows(np.array([stamp]), np.array([first_row]), seen, row_time, exposure)
