"""Records a drive under lamps as a rosbag2 bag, with ground truth."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from operator import itemgetter
from pathlib import Path

from scene_simulator import scene_messages
from scene_simulator.errors import SceneError
from scene_simulator.floor_bag import START_NS
from scene_simulator.lamp_drive import LampDrive, LampFrame
from shirube_bags.bag_writer import BagWriter
from shirube_core.files import write_text

CAMERA_FRAME = 'ceiling_camera_optical_frame'

JPEG_QUALITY = 60
_IMU_PERIOD = 0.02
"""[s]"""

_Entry = tuple[int, str, str, object]
"""Stamp [ns], topic, message type, message."""


def record_lamp_drive(drive: LampDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive; every message is received at its own stamp, in the order of the stamps.

    Args:
        drive: what to record.
        path: folder of the bag; must not exist.
        seconds: length of the recording [s].

    Yields:
        the number of each image after it is written, for progress display.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    drive.frame_count(seconds)
    images = (entry for frame in drive.frames(seconds) for entry in _image_entries(drive, frame))
    entries = heapq.merge(
        _odometry_entries(drive, seconds), _imu_entries(drive, seconds), images, key=itemgetter(0)
    )
    count = 0
    with BagWriter(path) as bag:
        for stamp, topic, kind, message in entries:
            bag.write(topic, kind, message, stamp)
            if topic == '/image_raw/compressed':
                yield count
                count += 1


def write_beacons(lamps: Sequence[tuple[int, tuple[float, float, float]]], radius: float, path: Path) -> None:
    """Write the lamps as the beacons file that vlc_beacon takes.

    Args:
        lamps: ID and place of each [m].
        radius: radius of the luminous disc of each lamp [m].
        path: file to write; an existing file is replaced.

    Raises:
        SceneError: the file cannot be written.
    """
    rows = [f'  - {{id: {beacon}, xyz: [{x}, {y}, {z}], radius: {radius}}}\n' for beacon, (x, y, z) in lamps]
    try:
        write_text(path, ''.join(['beacons:\n', *rows]))
    except OSError as error:
        raise SceneError(f'{path}: cannot be written ({error.strerror}); choose a writable place') from error


def _nanoseconds(time: float) -> int:
    return START_NS + round(time * 1e9)


def _image_entries(drive: LampDrive, frame: LampFrame) -> Iterator[_Entry]:
    """Yield an image, its calibration and the true pose when its exposure began."""
    stamp = _nanoseconds(frame.stamp)
    truth = scene_messages.pose_stamped(frame.pose, 'map', stamp)
    info = scene_messages.camera_info(drive.camera.intrinsics, CAMERA_FRAME, stamp)
    image = scene_messages.compressed_image(
        frame.photo.image, CAMERA_FRAME, stamp, JPEG_QUALITY, progressive=True
    )
    yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
    yield stamp, '/camera_info', 'sensor_msgs/msg/CameraInfo', info
    yield stamp, '/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', image


def _odometry_entries(drive: LampDrive, seconds: float) -> Iterator[_Entry]:
    for reading in drive.odometry(seconds):
        stamp = _nanoseconds(reading.time)
        message = scene_messages.odometry(reading.pose, (reading.forward, reading.yaw_rate), stamp)
        yield stamp, '/odom', 'nav_msgs/msg/Odometry', message


def _imu_entries(drive: LampDrive, seconds: float) -> Iterator[_Entry]:
    for reading in drive.tilt_readings(seconds, _IMU_PERIOD):
        stamp = _nanoseconds(reading.time)
        yield stamp, '/imu', 'sensor_msgs/msg/Imu', scene_messages.imu(reading, 'base_link', stamp)
