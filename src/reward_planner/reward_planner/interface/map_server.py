"""Publishes maps with transient local durability.

Loads and saves the map.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from nav_msgs.msg import OccupancyGrid
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Header

from reward_planner.core.navigator import Navigator
from reward_planner.core.occupancy_map import UNKNOWN, GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.files.occupancy_map_file import check_yaml_suffix, load_occupancy_map, save_occupancy_map
from reward_planner.node_settings import NodeSettings
from shirube_ros.occupancy_conversion import occupancy_grid
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


_SHIFT_MIN = 0.01  # smaller shifts are rounding errors of the file [cells]


def load_static_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Load map_file into a navigator, if it is set; return a one-line warning of a shift, empty if there is none.

    Raises:
        RewardPlannerError: the file is missing or corrupted, has another resolution or too many cells, or save_file has
            a wrong suffix.
    """
    if settings.save_file:
        check_yaml_suffix(Path(settings.save_file))
    if not settings.map_file:
        return ''
    grid = load_occupancy_map(Path(settings.map_file), navigator.mapper.map.resolution)
    navigator.set_static_map(grid)
    side = grid.frame.resolution
    dx, dy = (side * (round(at / side) - at / side) for at in (grid.frame.origin_x, grid.frame.origin_y))
    if max(abs(dx), abs(dy)) < _SHIFT_MIN * side:
        return ''
    return (
        f'{settings.map_file}: its origin is not a multiple of its resolution; the map is shifted by '
        f'{1e3 * dx:.0f} mm in x and {1e3 * dy:.0f} mm in y'
    )


def save_global_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Save the map and return the name of its file.

    Raises:
        RewardPlannerError: the map is empty, no file is set, or it cannot be written.
    """
    name = settings.save_file or settings.map_file
    if not name:
        raise RewardPlannerError('no file to save to; set save_file')
    known = navigator.mapper.map.occupancy()
    if known is None:
        raise RewardPlannerError('the map is empty; wait for the first frame')
    try:
        save_occupancy_map(Path(name), OccupancyMap(*known))
    except OSError as fault:
        raise RewardPlannerError(f'{name}: {fault.strerror}; choose a writable path') from fault
    return name
