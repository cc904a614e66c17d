"""What a rolling shutter sees of a lamp in one frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampRows:
    """Brightness of a lamp, row by row.

    Attributes:
        stamp: when the exposure of the image's row 0 began [s].
        first_row: of the lamp in the image.
        brightness: shape (rows,), mean of each row over the lamp, in any unit.
        row_time: between the beginnings of two rows [s].
        exposure: of a row [s].
    """

    stamp: float
    first_row: int
    brightness: NDArray[np.float64]
    row_time: float
    exposure: float

    @property
    def middle(self) -> float:
        """When the middle of the lamp was seen [s]."""
        rows = self.first_row + 0.5 * (len(self.brightness) - 1)
        return self.stamp + rows * self.row_time + 0.5 * self.exposure
