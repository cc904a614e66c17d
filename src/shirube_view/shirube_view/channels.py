"""What the page shows: topics and their types, and messages as JSON."""

from __future__ import annotations

import base64
import math
import zlib
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_ros.camera.image import array_from_compressed_image, array_from_image, depth_from_image

_PICTURE_WIDTH, _JPEG_QUALITY, _DEPTH_MAX = 640, 70, 5.0
"""Largest width [px] and quality of a sent picture, and the depth that is shown black [m]."""


class Kind(Enum):
    """How messages of a channel are sent: the newest, every one, changes of a grid, or as pictures on demand."""

    NEWEST = 'newest'
    EVERY = 'every'
    GRID = 'grid'
    PICTURE = 'picture'


@dataclass(frozen=True)
class Channel:
    """One topic that the page shows.

    Attributes:
        name: name on the page.
        topic: relative name of the topic.
        type: message type.
        kind: how messages are sent.
        is_latched: whether the topic is transient local.
    """

    name: str
    topic: str
    type: str
    kind: Kind = Kind.NEWEST
    is_latched: bool = False


_POSE, _POSE_COVARIANCE = 'geometry_msgs/msg/PoseStamped', 'geometry_msgs/msg/PoseWithCovarianceStamped'
_MARKERS, _STRING = 'visualization_msgs/msg/MarkerArray', 'std_msgs/msg/String'
_GRID, _IMAGE = 'nav_msgs/msg/OccupancyGrid', 'sensor_msgs/msg/Image'
LOCALIZERS = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')

CHANNELS = (
    Channel('map', 'reward_planner/map', _GRID, Kind.GRID, is_latched=True),
    Channel('local_map', 'reward_planner/local_map', _GRID, Kind.GRID, is_latched=True),
    Channel('plan', 'reward_planner/plan', 'nav_msgs/msg/Path', is_latched=True),
    Channel('waypoint', 'reward_planner/next_waypoint', _POSE),
    Channel('people', 'reward_planner/moving_obstacles', _MARKERS),
    Channel('goal', 'goal_pose', _POSE),
    Channel('fused', 'pose_arbiter/odometry', 'nav_msgs/msg/Odometry'),
    Channel('truth', 'ground_truth', _POSE),
    Channel('odom', 'odom', 'nav_msgs/msg/Odometry'),
    *(Channel(name, f'{name}/pose_with_covariance', _POSE_COVARIANCE) for name in LOCALIZERS),
    Channel('dots', 'floor_localizer/dots', _MARKERS),
    Channel('beacons', 'vlc_beacon/beacons', _MARKERS),
    Channel('targets', 'stereo_landmark/targets', _MARKERS),
    Channel('stop_zone', 'collision_monitor/stop_zone', 'geometry_msgs/msg/PolygonStamped'),
    Channel('slow_zone', 'collision_monitor/slow_down_zone', 'geometry_msgs/msg/PolygonStamped'),
    Channel('monitor', 'collision_monitor/state', _STRING),
    Channel('cmd_vel', 'cmd_vel', 'geometry_msgs/msg/TwistStamped'),
    Channel('command', 'vlc_beacon/command', _STRING),
    Channel('diagnostics', '/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', Kind.EVERY),
    Channel('floor picture', 'floor_localizer/debug_image', _IMAGE, Kind.PICTURE),
    Channel('lamp picture', 'vlc_beacon/debug_image', _IMAGE, Kind.PICTURE),
    Channel('landmark picture', 'stereo_landmark/debug_image', _IMAGE, Kind.PICTURE),
    Channel('depth picture', 'depth/image', _IMAGE, Kind.PICTURE),
)
RECORDED_PICTURES = {
    'floor picture': ('floor/image_raw/compressed', 'image_raw/compressed', 'floor/image_raw', 'image_raw'),
    'lamp picture': ('ceiling/image_raw/compressed', 'ceiling/image_raw'),
    'landmark picture': ('left/image_rect/compressed', 'left/image_rect'),
}
"""Topics of pictures in bags without debug images."""


def plain(value: Any) -> Any:
    """Return a message of rosbags as JSON data; numbers that are not finite become None."""
    if isinstance(value, float | np.floating):
        return round(float(value), 5) if math.isfinite(value) else None
    if isinstance(value, str | int | bytes) or value is None:
        return value.decode(errors='replace') if isinstance(value, bytes) else value
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(each) for each in (value.tolist() if isinstance(value, np.ndarray) else value)]
    return {field.name: plain(getattr(value, field.name)) for field in fields(value) if field.name != '__msgtype__'}


@dataclass(frozen=True)
class Grid:
    """An occupancy grid: cells, shape (height, width), lower left corner (x, y) [m] and size of a cell [m]."""

    cells: NDArray[np.int8]
    origin: tuple[float, float]
    resolution: float

    @classmethod
    def from_message(cls, message: Any) -> Grid | None:
        """Return the grid of a message, None if its size is wrong."""
        info = message.info
        if len(message.data) != info.height * info.width or not len(message.data):
            return None
        corner = info.origin.position
        cells = np.asarray(message.data, dtype=np.int8).reshape(info.height, info.width)
        return cls(cells, (corner.x, corner.y), info.resolution)

    def as_json(self, before: Grid | None) -> dict[str, Any]:
        """Return the rectangle of cells that differ from an earlier grid, or all cells if it lay elsewhere."""
        rows, columns = slice(0, self.cells.shape[0]), slice(0, self.cells.shape[1])
        place = (self.cells.shape, self.origin, self.resolution)
        is_patch = before is not None and place == (before.cells.shape, before.origin, before.resolution)
        if is_patch and before is not None:
            changed = self.cells != before.cells
            rows, columns = (_extent(changed.any(axis=axis)) for axis in (1, 0))
        cells = np.ascontiguousarray(self.cells[rows, columns])
        return {
            'patch': is_patch,
            'size': self.cells.shape,
            'origin': self.origin,
            'resolution': self.resolution,
            'corner': (rows.start, columns.start),
            'shape': cells.shape,
            'cells': base64.b64encode(zlib.compress(cells.tobytes(), 1)).decode(),
        }


def _extent(is_changed: NDArray[np.bool_]) -> slice:
    indices = np.flatnonzero(is_changed)
    return slice(int(indices[0]), int(indices[-1]) + 1) if len(indices) else slice(0, 0)


def jpeg(message: Any, topic: str) -> bytes:
    """Return an image message as JPEG, large ones smaller, depth in grey; raise an ImageError for an invalid one."""
    if hasattr(message, 'format'):
        pixels = array_from_compressed_image(message, topic)
    elif message.encoding in ('32FC1', '16UC1'):
        near = 1.0 - np.nan_to_num(depth_from_image(message, topic), nan=_DEPTH_MAX, posinf=_DEPTH_MAX) / _DEPTH_MAX
        pixels = (255.0 * near.clip(0.0, 1.0)).astype(np.uint8)
    else:
        pixels = array_from_image(message, topic)
    shrink = _PICTURE_WIDTH / pixels.shape[1]
    if shrink < 1.0:
        pixels = np.asarray(
            cv2.resize(pixels, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA), dtype=np.uint8
        )
    return cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1].tobytes()
