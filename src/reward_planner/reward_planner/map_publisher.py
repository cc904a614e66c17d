"""Publishes maps with transient local durability."""

from __future__ import annotations

import numpy as np
from nav_msgs.msg import OccupancyGrid
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Header

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.grid.occupancy_map import UNKNOWN
from shirube_ros.map_conversion import occupancy_grid
from shirube_ros.quality_of_service import map_profile


class MapPublisher:
    """Publishes one map on one topic."""

    def __init__(self, node: Node, topic: str) -> None:
        """Create the publisher.

        Args:
            node: node that publishes.
            topic: topic of the map.
        """
        self._publisher: Publisher = node.create_publisher(OccupancyGrid, topic, map_profile())
        self._last_grid: GridFrame | None = None

    def publish(self, grid: GridFrame, cells: NDArray[np.int8], header: Header) -> None:
        """Publish cells, shape (rows, columns), as OccupancyGrid."""
        self._last_grid = grid
        origin = (grid.origin_x, grid.origin_y)
        self._publisher.publish(occupancy_grid(cells, origin, grid.resolution, header))

    def publish_unknown(self, header: Header) -> None:
        """Publish an unknown map of the last size, so that late subscribers do not get the old one."""
        if self._last_grid is not None:
            self.publish(self._last_grid, np.full(self._last_grid.shape, UNKNOWN, dtype=np.int8), header)
