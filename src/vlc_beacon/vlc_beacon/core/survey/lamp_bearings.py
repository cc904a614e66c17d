"""Where one lamp was seen from known places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampBearings:
    """Sightings of one lamp.

    Attributes:
        stamps: shape (n,), rising [s].
        positions: shape (n, 3), of the camera in the map [m].
        rotations: shape (n, 3, 3), ``R_map_camera``.
        rays: shape (n, 2), x and y of the undistorted rays in the optical frame, whose z is 1.
        sigmas: shape (n,), standard deviation of the rays along each axis.
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    rotations: NDArray[np.float64]
    rays: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of sightings."""
        return len(self.stamps)

    def subset(self, which: NDArray[np.bool_]) -> LampBearings:
        """Return some of the sightings, shape (n,) of bool."""
        return LampBearings(
            self.stamps[which],
            self.positions[which],
            self.rotations[which],
            self.rays[which],
            self.sigmas[which],
        )
