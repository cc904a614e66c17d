"""What a rolling shutter sees of a lamp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class LampRows:
    """Brightness of a lamp, row by row, in frames in which it covers equally many rows; mostly in one.

    Attributes:
        stamps: shape (n,), when the exposure of the images' row 0 began [s].
        first_rows: shape (n,), the lamp's first row in each image.
        brightness: shape (n, rows), mean of each row over the lamp, in any unit.
        row_time: between the beginnings of two rows [s].
        exposure: of a row [s].
    """

    stamps: NDArray[np.float64]
    first_rows: NDArray[np.int64]
    brightness: NDArray[np.float64]
    row_time: float
    exposure: float

    @property
    def middles(self) -> NDArray[np.float64]:
        """Shape (n,), when the middle of the lamp was seen [s]."""
        rows = self.first_rows + 0.5 * (self.brightness.shape[1] - 1)
        return self.stamps + rows * self.row_time + 0.5 * self.exposure

    def without_damage(self) -> LampRows:
        """Return the frames in which every row is a number."""
        kept = np.isfinite(self.brightness).all(axis=1)
        if kept.all():
            return self
        return LampRows(
            self.stamps[kept], self.first_rows[kept], self.brightness[kept], self.row_time, self.exposure
        )


def rows_of_frame(
    stamp: float, first_row: int, brightness: ArrayLike, row_time: float, exposure: float
) -> LampRows:
    """Return the rows of a lamp in one frame; brightness has shape (rows,), the rest is as in `LampRows`."""
    seen = np.asarray(brightness, float)[None]
    return LampRows(np.array([stamp]), np.array([first_row]), seen, row_time, exposure)
