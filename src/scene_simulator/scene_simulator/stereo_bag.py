"""Records a drive with a stereo rig as a rosbag2 bag, with ground truth."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path

from scene_simulator import scene_messages
from scene_simulator.floor_bag import START_NS
from scene_simulator.stereo_drive import StereoDrive, StereoFrame
from shirube_bags.bag_writer import BagWriter

JPEG_QUALITY = 85

_Entry = tuple[int, str, str, object]
"""Stamp [ns], topic, message type, message."""


def record_stereo_drive(drive: StereoDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive; every message is received at its own stamp, in the order of the stamps.

    Rectified images are on ``image_rect``, those of a rig that distorts on ``image_raw``.

    Args:
        drive: what to record.
        path: folder of the bag; must not exist.
        seconds: length of the recording [s].

    Yields:
        the number of each pair after it is written, for progress display.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    drive.frame_count(seconds)
    images = (entry for frame in drive.frames(seconds) for entry in _frame_entries(drive, frame))
    entries = heapq.merge(
        _odometry_entries(drive, seconds), _imu_entries(drive, seconds), images, key=itemgetter(0)
    )
    count = 0
    with BagWriter(path) as bag:
        for stamp, topic, kind, message in entries:
            bag.write(topic, kind, message, stamp)
            if topic.startswith('/right/image'):
                yield count
                count += 1


def _nanoseconds(time: float) -> int:
    return START_NS + round(time * 1e9)


def _frame_entries(drive: StereoDrive, frame: StereoFrame) -> Iterator[_Entry]:
    """Yield the true pose, and calibration and image of the left and of the right camera."""
    stamp = _nanoseconds(frame.stamp)
    truth = scene_messages.pose_stamped(frame.pose, 'map', stamp)
    yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
    name = 'image_rect' if drive.rig.is_rectified else 'image_raw'
    calibrations = drive.rig.calibrations()
    for side, image, found in zip(('left', 'right'), (frame.left, frame.right), calibrations, strict=True):
        camera = f'{side}_camera_optical_frame'
        info = scene_messages.camera_info(found.camera, camera, stamp, found.rotation, found.projection)
        jpeg = scene_messages.compressed_image(image, camera, stamp, JPEG_QUALITY, progressive=True)
        yield stamp, f'/{side}/camera_info', 'sensor_msgs/msg/CameraInfo', info
        yield stamp, f'/{side}/{name}/compressed', 'sensor_msgs/msg/CompressedImage', jpeg


def _odometry_entries(drive: StereoDrive, seconds: float) -> Iterator[_Entry]:
    for reading in drive.odometry(seconds):
        stamp = _nanoseconds(reading.time)
        message = scene_messages.odometry(reading.pose, (reading.forward, reading.yaw_rate), stamp)
        yield stamp, '/odom', 'nav_msgs/msg/Odometry', message


def _imu_entries(drive: StereoDrive, seconds: float) -> Iterator[_Entry]:
    for reading in drive.tilt_readings(seconds):
        stamp = _nanoseconds(reading.time)
        yield stamp, '/imu', 'sensor_msgs/msg/Imu', scene_messages.imu(reading, 'base_link', stamp)
