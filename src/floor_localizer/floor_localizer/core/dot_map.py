"""The map of the floor's dots (the paper's floor dot database, 2.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class DotMap:
    """All dots of a floor in the map frame.

    Attributes:
        points: shape (N, 2), centres of the dots [m].
        diameters: shape (N,), diameters of the discs of equal area [m], NaN where unknown.
    """

    points: NDArray[np.float64]
    diameters: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.points)
