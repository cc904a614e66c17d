"""Occupancy grid with its geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.reward_planner_error import RewardPlannerError

UNKNOWN = -1
FREE = 0
OCCUPIED = 100

OCCUPIED_THRESHOLD = 65  # map_server's default occupied_thresh, 0.65 [%]
FREE_THRESHOLD = 25  # map_server's default free_thresh, 0.25 [%]


@dataclass(frozen=True)
class OccupancyMap:
    """An occupancy grid.

    Attributes:
        frame: origin, resolution and size of the grid.
        occupancy: probability of occupancy, 0 to 100 %, -1 for unknown; int8, shape (rows, columns).

    Raises:
        RewardPlannerError: the shapes of array and frame differ.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]

    def __post_init__(self) -> None:
        if self.occupancy.shape != self.frame.shape:
            raise RewardPlannerError(
                f'the map has {self.occupancy.shape} rows and columns, its frame {self.frame.shape}; they must be equal'
            )

    def occupied(self) -> NDArray[np.bool_]:
        """Return the occupied cells, shape (rows, columns); unknown cells are not occupied."""
        return self.occupancy >= OCCUPIED_THRESHOLD
