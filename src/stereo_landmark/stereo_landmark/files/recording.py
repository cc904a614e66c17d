"""Stereo pairs of a bag: topics, calibrations, synchronization and tilt."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import TiltBuffer
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.errors import CameraInfoError
from shirube_ros.offline.recording import (
    RecordedImage,
    RecordedTilt,
    Recording,
    RecordingTopics,
    choose_camera_info,
    choose_images,
    choose_imu,
)
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import Side, StampSynchronizer
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def calibration_from_camera_info(message: Any, topic: str) -> CameraCalibration:
    """Return the calibration of the raw and the rectified image.

    Args:
        message: sensor_msgs/CameraInfo of a camera of a stereo pair.
        topic: topic name for error messages.

    Raises:
        CameraInfoError: the camera is not calibrated, or not as part of a stereo pair.
    """
    camera = camera_from_camera_info(message, topic)
    rotation, projection = (tuple(float(number) for number in field) for field in (message.r, message.p))
    try:
        return CameraCalibration(camera, rotation, projection)
    except StereoLandmarkError as fault:
        raise CameraInfoError(f'{topic}: {fault}') from fault


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


_QUEUE_SIZE = 10
"""Queue size per camera for synchronization."""

_Image = RecordedImage[CameraCalibration]


@dataclass(frozen=True)
class RecordedPair:
    """A stereo pair of a bag, raw or rectified.

    Attributes:
        left: image of the left camera.
        right: image of the right camera.
        tilt: roll and pitch of the base by the nearest IMU reading [rad], None without one.
    """

    left: _Image
    right: _Image
    tilt: tuple[float, float] | None


def recorded_pairs(
    bag: BagReader, topics: RecordingTopics, tolerance: float, begin_ns: int | None = None
) -> Iterator[RecordedPair]:
    """Yield the stereo pairs of a bag; unpaired images are skipped, as the cameras may start at different times.

    Args:
        bag: open bag.
        topics: topics of the bag to use.
        tolerance: largest stamp difference of a pair [s].
        begin_ns: stamp of the first image to use [ns]; None for all images.

    Raises:
        BagError: the bag is corrupted.
    """
    synchronizer: StampSynchronizer[_Image] = StampSynchronizer(round(tolerance * 1e9), _QUEUE_SIZE)
    tilts = TiltBuffer()
    pending: tuple[_Image, _Image] | None = None
    for message in pair_recording(bag, topics).messages():
        if isinstance(message, RecordedTilt):
            tilts.add(message.stamp_ns * 1e-9, *message.tilt)
            if pending is not None and message.stamp_ns >= pending[0].stamp_ns:
                yield _attach_tilt(pending, tilts)
                pending = None
        elif isinstance(message, RecordedImage) and (begin_ns is None or message.stamp_ns >= begin_ns):
            pair = None
            with suppress(StereoLandmarkError):  # the caller reports a bag without pairs
                pair = synchronizer.add(Side(message.camera), message.stamp_ns, message)
            if pair is None:
                continue
            if pending is not None:
                yield _attach_tilt(pending, tilts)
            # Wait for the next IMU reading, which may be nearer than the previous one.
            pending = pair
    if pending is not None:
        yield _attach_tilt(pending, tilts)


def _attach_tilt(pair: tuple[_Image, _Image], tilts: TiltBuffer) -> RecordedPair:
    return RecordedPair(*pair, tilts.tilt_at(pair[0].stamp_ns * 1e-9))
