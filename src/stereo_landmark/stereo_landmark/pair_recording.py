"""Stereo images, calibrations and IMU tilt of a bag."""

from __future__ import annotations

from typing import Any

from shirube_bags.bag_reader import BagReader
from shirube_ros.offline.recording import (
    Recording,
    RecordingTopics,
    choose_camera_info,
    choose_images,
    choose_imu,
)
from stereo_landmark.calibration_message import calibration_from_camera_info
from stereo_landmark.core.pair.camera_calibration import CameraCalibration


def choose_topics(bag: BagReader, requested: dict[str, Any], *, is_raw: bool) -> RecordingTopics:
    """Return the topics to use, left camera first: the requested ones, otherwise the default ones.

    Args:
        bag: open bag.
        requested: topic names by ``left_image``, ``left_camera_info``, ``right_image``, ``right_camera_info``, ``imu``.
        is_raw: whether to prefer raw images if the bag has both.

    Raises:
        BagError: a requested topic is missing or has another type, or the choice is empty or ambiguous.
    """
    images, camera_infos = [], []
    image_names = ('image_raw', 'image_rect') if is_raw else ('image_rect', 'image_raw')
    for side in ('left', 'right'):
        usual = tuple(f'/{side}/{name}{end}' for name in image_names for end in ('', '/compressed'))
        images.append(choose_images(bag, requested.get(f'{side}_image'), usual))
        name = requested.get(f'{side}_camera_info')
        camera_infos.append(choose_camera_info(bag, name, f'/{side}/camera_info'))
    return RecordingTopics(tuple(images), tuple(camera_infos), imu=choose_imu(bag, requested.get('imu')))


def pair_recording(bag: BagReader, topics: RecordingTopics) -> Recording[CameraCalibration]:
    """Return the messages of a bag with stereo calibrations; images may be raw."""
    return Recording(bag, topics, calibration_from_camera_info)
