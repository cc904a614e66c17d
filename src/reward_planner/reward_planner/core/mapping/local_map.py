"""The map around the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame


@dataclass(frozen=True)
class LocalMap:
    """What the voxels around the robot say of the floor.

    Attributes:
        frame: where the cells are.
        occupancy: shape (rows, columns), OCCUPIED, FREE or UNKNOWN.
        observed: shape (rows, columns), where this is news for the global map: cells that are occupied or free, and
            UNKNOWN ones whose obstacle was taken back by rays. Evidence that has faded or is partial is none.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]
    observed: NDArray[np.bool_]
