"""What of the pose is known beforehand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.pose.bearing_model import STATES


@dataclass(frozen=True)
class KnownStates:
    """Parts of the pose that are given.

    Attributes:
        height: of the base in the map frame [m], None where it is looked for.
    """

    height: float | None = None

    @property
    def unknowns(self) -> int:
        """How many of x, y, z and yaw are looked for."""
        return 4 - (self.height is not None)

    def free(self, *, tilt: bool) -> NDArray[np.bool_]:
        """Return which states are looked for, shape (6,).

        Args:
            tilt: whether the tilt's error is.
        """
        free = np.ones(STATES, dtype=np.bool_)
        free[2] = self.height is None
        free[4:] = tilt
        return free
