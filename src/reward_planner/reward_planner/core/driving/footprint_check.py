"""Whether the robot's footprint is free along a route, turned into the direction of the route."""

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.safety.footprint import Footprint

_CELL_MARGIN = 0.75  # from the centre of an occupied cell to its edge, rounded up [cells]


class FootprintCheck:
    """Points that fill a footprint, to be looked up in a costmap.

    Attributes:
        clearance_min: clearance above which the footprint is free in every direction [m].
    """

    def __init__(self, footprint: Footprint, resolution: float) -> None:
        """Take a footprint, and the side of the costmap's cells [m]."""
        self._margin, self._radius = _CELL_MARGIN * resolution, footprint.radius
        self.clearance_min = footprint.radius + self._margin
        count = int(np.ceil(footprint.radius / resolution))
        steps = resolution * np.arange(-count, count + 1)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        # The corners, and points of the interior. Routes keep the inscribed circle free.
        inside = grid[footprint.distances(grid) <= 0.0]
        ends = np.roll(footprint.corners, -1, axis=0)
        shares = np.linspace(0.0, 1.0, 2 * count + 1, endpoint=False)[:, None, None]
        outline = (footprint.corners + shares * (ends - footprint.corners)).reshape(-1, 2)
        points = np.concatenate([outline, inside])
        self._points = points[np.hypot(*points.T) > footprint.inscribed_radius - resolution]

    def collides(self, points_map: NDArray[np.float64], costmap: InflatedCostmap) -> NDArray[np.bool_]:
        """Return at which points of a route [m], shape (n, 2), the footprint touches an obstacle, shape (n,)."""
        collides = np.zeros(len(points_map), dtype=np.bool_)
        near = np.flatnonzero(costmap.clearance_at(points_map) <= self.clearance_min)
        if len(near) == 0 or len(points_map) < 2:
            return collides
        # Direction: the chord over a robot's radius ahead and behind, as lookahead smooths the steps of the grid.
        reach = 1 + int(self._radius / costmap.frame.resolution)
        ahead = points_map[np.minimum(near + reach, len(points_map) - 1)]
        x, y = (ahead - points_map[np.maximum(near - reach, 0)]).T
        yaw = np.arctan2(y, x)
        R = np.stack([np.cos(yaw), -np.sin(yaw), np.sin(yaw), np.cos(yaw)], axis=1).reshape(-1, 2, 2)
        placed = points_map[near, None] + self._points @ R.transpose(0, 2, 1)
        collides[near] = (costmap.clearance_at(placed) <= self._margin).any(axis=1)
        return collides
