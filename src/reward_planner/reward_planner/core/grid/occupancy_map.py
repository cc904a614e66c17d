"""A map of what is occupied, free and unknown, as OccupancyGrid has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.reward_planner_error import RewardPlannerError

UNKNOWN = -1
FREE = 0
OCCUPIED = 100

OCCUPIED_FROM = 65  # as map_server's occupied_thresh of 0.65 [%]
FREE_BELOW = 25  # as its free_thresh of 0.25 [%]


@dataclass(frozen=True)
class OccupancyMap:
    """A map.

    Attributes:
        frame: where its cells lie.
        occupancy: int8, shape (rows, columns): how probably a cell is occupied, 0 to 100 %; -1 where nothing is known.

    Raises:
        RewardPlannerError: the array has another shape than the frame.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]

    def __post_init__(self) -> None:
        if self.occupancy.shape != self.frame.shape:
            raise RewardPlannerError(
                f'the map has {self.occupancy.shape} rows and columns, its frame {self.frame.shape}; give both alike'
            )

    def occupied(self) -> NDArray[np.bool_]:
        """Return the cells that are occupied, shape (rows, columns); what is unknown is not."""
        return self.occupancy >= OCCUPIED_FROM
