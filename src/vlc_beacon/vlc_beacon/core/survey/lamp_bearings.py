"""Bearings to one lamp from known camera poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampBearings:
    """Bearings to one lamp.

    Attributes:
        stamps: stamps, shape (n,), increasing [s].
        positions: camera positions in the map, shape (n, 3) [m].
        rotations: camera rotations ``R_map_camera``, shape (n, 3, 3).
        rays: x and y of the undistorted rays with z = 1 in the optical frame, shape (n, 2).
        sigmas: standard deviation of the rays along each axis, shape (n,).
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    rotations: NDArray[np.float64]
    rays: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of bearings."""
        return len(self.stamps)

    def subset(self, mask: NDArray[np.bool_]) -> LampBearings:
        """Return the bearings selected by a mask, shape (n,)."""
        return LampBearings(
            self.stamps[mask],
            self.positions[mask],
            self.rotations[mask],
            self.rays[mask],
            self.sigmas[mask],
        )
