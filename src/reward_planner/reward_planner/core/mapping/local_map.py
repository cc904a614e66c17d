"""The local map around the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame


@dataclass(frozen=True)
class LocalMap:
    """Occupancy of the floor around the robot, from its voxels.

    Attributes:
        frame: origin, resolution and size of the grid.
        occupancy: OCCUPIED, FREE or UNKNOWN, shape (rows, columns).
        observed: cells to write to the global map, shape (rows, columns): occupied, free, and UNKNOWN ones whose
            obstacle was cleared by rays. Decayed or partial evidence does not count.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]
    observed: NDArray[np.bool_]
