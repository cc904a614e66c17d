"""Publishes, loads, saves and clears the map."""

from pathlib import Path

import numpy as np
from nav_msgs.msg import OccupancyGrid
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.time import Time
from std_msgs.msg import Header

from reward_planner.core.mapping.global_map import CostmapMasks, SpeedMask
from reward_planner.core.navigator import MappedFrame, Navigator
from reward_planner.core.occupancy_map import UNKNOWN, GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.files.occupancy_map_file import check_yaml_suffix, load_occupancy_map, save_occupancy_map
from reward_planner.node_settings import NodeSettings
from shirube_ros.callback_guard import CallbackGuard, create_trigger_service
from shirube_ros.message_conversion import occupancy_grid
from shirube_ros.quality_of_service import map_profile

_SHIFT_MIN = 0.01  # smaller shifts are rounding errors of the file [cells]


class MapServer:
    """Publishes ``~/map`` and ``~/local_map``, transient local, and serves ``~/clear_map`` and ``~/save_map``."""

    def __init__(self, node: Node, guard: CallbackGuard, navigator: Navigator, settings: NodeSettings) -> None:
        """Create publishers and services; ``~/map`` is published by `publish_map` only if it changed."""
        self._clock, self._navigator, self._settings = node.get_clock(), navigator, settings
        self._has_new_map = bool(settings.map_file)
        self._map, self._local_map = (
            node.create_publisher(OccupancyGrid, topic, map_profile()) for topic in ('~/map', '~/local_map')
        )
        self._last_frames: dict[Publisher, GridFrame] = {}
        create_trigger_service(node, guard, '~/clear_map', self._clear_map)
        create_trigger_service(node, guard, '~/save_map', self._save_map)

    def publish_map(self) -> None:
        """Publish the whole map, if it changed since the last time."""
        known = self._navigator.mapper.map.occupancy() if self._has_new_map else None
        self._has_new_map = False
        if known is not None:
            self._publish(self._map, *known, self._clock.now())

    def publish_local_map(self, frame: MappedFrame) -> None:
        """Publish the local map of a frame with the stamp of the frame."""
        self._has_new_map = True
        stamp = Time(nanoseconds=round(1e9 * frame.stamp))
        self._publish(self._local_map, frame.local.frame, frame.local.occupancy, stamp)

    def _publish(self, publisher: Publisher, frame: GridFrame, cells: NDArray[np.int8], stamp: Time) -> None:
        self._last_frames[publisher] = frame
        header = Header(stamp=stamp.to_msg(), frame_id=self._settings.map_frame)
        origin = (frame.origin_x, frame.origin_y)
        publisher.publish(occupancy_grid(cells, origin, frame.resolution, header))

    def _clear_map(self) -> str:
        self._navigator.clear_map()
        self._has_new_map = False
        # Late subscribers get an unknown map of the last size instead of the old one.
        for publisher, frame in self._last_frames.items():
            unknown = np.full(frame.shape, UNKNOWN, dtype=np.int8)
            self._publish(publisher, frame, unknown, self._clock.now())
        return 'map cleared'

    def _save_map(self) -> str:
        return f'saved to {save_global_map(self._navigator, self._settings)}'


def load_static_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Load map_file and masks into a navigator, if set; return a one-line warning of a shift, empty if there is none.

    Raises:
        RewardPlannerError: the file is missing or corrupted, has another resolution or too many cells, or save_file has
            a wrong suffix.
    """
    if settings.save_file:
        check_yaml_suffix(Path(settings.save_file))
    navigator.mapper.map.masks = load_masks(settings)
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


def load_masks(settings: NodeSettings) -> CostmapMasks:
    """Load the masks that are set; a RewardPlannerError names a file or field that is missing or corrupted."""
    keepout, speed = (
        load_occupancy_map(Path(name)) if name else None
        for name in (settings.keepout_mask_file, settings.speed_mask_file)
    )
    if speed is None:
        return CostmapMasks(keepout)
    base, multiplier = settings.speed_mask_base, settings.speed_mask_multiplier
    return CostmapMasks(keepout, SpeedMask(speed, settings.speed_mask_type == 'percent', base, multiplier))


def save_global_map(navigator: Navigator, settings: NodeSettings) -> str:
    """Save the map and return the name of its file; a RewardPlannerError says why it cannot be saved."""
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
