"""Known components of the pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.pose.bearing_model import STATES


@dataclass(frozen=True)
class KnownStates:
    """Components of the pose that are not estimated.

    Attributes:
        height: height of the base in the map frame [m], None if it is estimated.
    """

    height: float | None = None

    @property
    def unknowns(self) -> int:
        """Number of estimated components of x, y, z and yaw."""
        return 4 - (self.height is not None)

    def free_states(self, *, tilt: bool) -> NDArray[np.bool_]:
        """Return the mask of estimated states, shape (6,).

        Args:
            tilt: whether the tilt error is estimated.
        """
        free_states = np.ones(STATES, dtype=np.bool_)
        free_states[2] = self.height is None
        free_states[4:] = tilt
        return free_states
