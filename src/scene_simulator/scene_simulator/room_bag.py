"""Records a drive through a furnished room as a rosbag2 bag, with ground truth poses and map."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator import scene_messages
from scene_simulator.errors import SceneError
from scene_simulator.floor_bag import START_NS, odometry_messages
from scene_simulator.room_drive import RoomDrive
from shirube_bags.bag_writer import BagWriter

PICTURE_RATE, POSE_RATE = 5, 20
"""[Hz]"""
JPEG_QUALITY = 70
RESOLUTION = 0.05
"""Resolution of the true map [m]; cell borders are at its multiples."""
HEIGHTS = (0.1, 1.2)
"""Height range of the obstacles in the true map [m]."""

_WHEEL_NOISE = 3
_BORDER = 4  # cells of the true map outside of the room

_Entry = tuple[int, str, str, object]
"""Stamp [ns], topic, message type, message."""


def record_room_drive(scene: RoomDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive; every message is received at its own stamp, in the order of the stamps.

    Args:
        scene: what to record.
        path: folder of the bag; must not exist.
        seconds: length of the recording [s].

    Yields:
        the number of each instant after its three pictures are written, for progress display.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive, or the room cannot be furnished.
    """
    instant_count(seconds)
    entries = heapq.merge(
        _map_entries(scene),
        _odometry_entries(scene, seconds),
        _pose_entries(scene, seconds),
        _picture_entries(scene, seconds),
        key=itemgetter(0),
    )
    count = 0
    with BagWriter(path) as bag:
        for stamp, topic, kind, message in entries:
            bag.write(topic, kind, message, stamp)
            if topic == '/ground_truth':
                yield count
                count += 1


def instant_count(seconds: float) -> int:
    """Return how often the cameras take pictures in a recording of this length [s].

    Raises:
        SceneError: the length is not positive.
    """
    if not 0.0 < seconds < math.inf:
        raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
    return math.ceil(seconds * PICTURE_RATE)


def true_map(scene: RoomDrive) -> tuple[NDArray[np.int8], tuple[float, float]]:
    """Return the true occupancy, shape (rows, columns), 0 or 100, and its lower left corner [m]."""
    size = np.array(scene.size)
    first = np.floor(size[:2] / RESOLUTION).astype(int) - _BORDER
    last = np.ceil(size[3:5] / RESOLUTION).astype(int) + _BORDER
    x, y = (RESOLUTION * first).tolist()
    columns, rows = (last - first).tolist()
    solid = scene.room.boxes.solid_cells((x, y), RESOLUTION, (rows, columns), HEIGHTS)
    return np.where(solid, 100, 0).astype(np.int8), (x, y)


def _times(rate: int, seconds: float) -> Iterator[tuple[int, float, int]]:
    """Yield number, time since the start [s] and stamp [ns]."""
    for index in range(math.ceil(seconds * rate)):
        yield index, index / rate, START_NS + round(index * 1e9 / rate)


def _map_entries(scene: RoomDrive) -> Iterator[_Entry]:
    message = scene_messages.occupancy_grid(*true_map(scene), RESOLUTION, START_NS)
    yield START_NS, '/truth/map', 'nav_msgs/msg/OccupancyGrid', message


def _odometry_entries(scene: RoomDrive, seconds: float) -> Iterator[_Entry]:
    rng = np.random.default_rng((scene.seed, _WHEEL_NOISE))
    for time_ns, message in odometry_messages(scene.drive.pose_at, seconds, rng):
        yield START_NS + time_ns, '/odom', 'nav_msgs/msg/Odometry', message


def _pose_entries(scene: RoomDrive, seconds: float) -> Iterator[_Entry]:
    for index, time, stamp in _times(POSE_RATE, seconds):
        message = scene_messages.pose_stamped(scene.localizer_pose(index, time), 'map', stamp)
        yield stamp, '/pose', 'geometry_msgs/msg/PoseStamped', message


def _picture_entries(scene: RoomDrive, seconds: float) -> Iterator[_Entry]:
    """Yield the pictures of each instant, their calibrations, and the true pose."""
    for index, time, stamp in _times(PICTURE_RATE, seconds):
        for name, picture in scene.pictures(index, time).items():
            frame = f'{name}_camera_optical_frame'
            info = scene_messages.camera_info(
                scene.rig.camera, frame, stamp, projection=scene.rig.projections[name]
            )
            image = scene_messages.compressed_image(picture, frame, stamp, JPEG_QUALITY)
            yield stamp, f'/{name}/camera_info', 'sensor_msgs/msg/CameraInfo', info
            yield stamp, f'/{name}/image_rect/compressed', 'sensor_msgs/msg/CompressedImage', image
        truth = scene_messages.pose_stamped(scene.drive.pose_at(time), 'map', stamp)
        yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
