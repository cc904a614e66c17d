"""Keep-out and speed masks in the format of Nav2's costmap filters."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.occupancy_map import OCCUPIED, GridFrame, OccupancyMap, resample_map
from reward_planner.core.route.route import LETHAL

_FRACTION_MIN = 0.05  # slowest speed of a mask: the robot can leave the zone [of the maximum]


@dataclass(frozen=True)
class SpeedMask:
    """Speed zones: a cell of value v limits the speed to base + multiplier v; 0 and unknown cells do not.

    Attributes:
        grid: values of 0 to 100, or unknown.
        is_percentage: whether limits are in percent of the maximum speed, else in m/s.
        base: base of CostmapFilterInfo, in the unit of the limits.
        multiplier: multiplier of CostmapFilterInfo.
    """

    grid: OccupancyMap
    is_percentage: bool
    base: float
    multiplier: float

    def limit_at(self, x: float, y: float, speed_max: float) -> float:
        """Return the limit at a place in the map [m] from the maximum speed, from 5 % of it up [m/s]."""
        row, column = self.grid.frame.cell_of((x, y))
        value = int(self.grid.occupancy[row, column]) if self.grid.frame.contains((row, column)) else 0
        if value <= 0:
            return speed_max
        limit = self.base + self.multiplier * value
        if self.is_percentage:
            limit *= 0.01 * speed_max
        return min(max(limit, _FRACTION_MIN * speed_max), speed_max)


@dataclass(frozen=True)
class CostmapMasks:
    """The masks of a map.

    Attributes:
        keepout: cells of 100 are not entered by the robot's centre, lower values above 0 are costs.
        speed: speed zones.
    """

    keepout: OccupancyMap | None = None
    speed: SpeedMask | None = None

    def keepout_costs(self, frame: GridFrame) -> NDArray[np.uint8] | None:
        """Return the costs of the cells of a frame, uint8, shape (rows, columns); None without a mask."""
        if self.keepout is None:
            return None
        values = np.maximum(resample_map(self.keepout, frame), 0)
        return (values.astype(np.int64) * LETHAL // OCCUPIED).astype(np.uint8)

    def speed_limit(self, x: float, y: float, speed_max: float) -> float:
        """Return the speed limit at a place in the map [m] from the maximum speed [m/s]."""
        return speed_max if self.speed is None else self.speed.limit_at(x, y, speed_max)
