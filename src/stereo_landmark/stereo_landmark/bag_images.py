"""What a bag holds of two cameras and the robot's tilt, in the order of its messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from shirube_bags.topic_choice import choose_topic
from shirube_ros.camera_info_conversion import check_image_size
from shirube_ros.image_conversion import array_from_compressed_image, array_from_image
from shirube_ros.message_error import CameraInfoError, MessageError
from shirube_ros.tilt_conversion import tilt_of_imu
from stereo_landmark.calibration_message import calibration_from_camera_info
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import Side
from stereo_landmark.files.grey_image import grey

_IMAGE, _COMPRESSED = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'
_CAMERA_INFO, _IMU = 'sensor_msgs/msg/CameraInfo', 'sensor_msgs/msg/Imu'
_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class BagTopics:
    """Which topics of a bag are used.

    Attributes:
        images: of the left and of the right camera.
        camera_infos: their calibrations.
        imu: empty for none.
    """

    images: tuple[str, str]
    camera_infos: tuple[str, str]
    imu: str


@dataclass(frozen=True)
class BagImage:
    """An image.

    Attributes:
        header: of its message.
        side: of its camera.
        stamp_ns: when it was taken [ns].
        pixels: shape (h, w), grey.
        calibration: of its camera.
    """

    header: Any
    side: Side
    stamp_ns: int
    pixels: NDArray[np.uint8]
    calibration: CameraCalibration


@dataclass(frozen=True)
class BagTilt:
    """How the robot leans.

    Attributes:
        header: of its message.
        tilt: roll and pitch of the base [rad].
    """

    header: Any
    tilt: tuple[float, float]


@dataclass(frozen=True)
class BadImage:
    """An image that cannot be used.

    Attributes:
        side: of its camera.
        stamp_ns: when it was taken [ns].
        fault: what is wrong, in a line.
    """

    side: Side
    stamp_ns: int
    fault: str


def choose_topics(bag: BagReader, named: dict[str, Any], *, is_raw: bool) -> BagTopics:
    """Return the topics to use: those that are named, else the usual ones.

    Args:
        bag: an open bag.
        named: by ``left_image``, ``left_camera_info``, ``right_image``, ``right_camera_info`` and ``imu``.

        is_raw: whether raw images are wanted, where there are both.

    Raises:
        BagError: a named topic is missing or of another type, or there is none, or several, to choose from.
    """
    images, infos = [], []
    kinds = ('image_raw', 'image_rect') if is_raw else ('image_rect', 'image_raw')
    for side in ('left', 'right'):
        usual = tuple(f'/{side}/{name}{end}' for name in kinds for end in ('', '/compressed'))
        images.append(choose_topic(bag, named.get(f'{side}_image'), (_IMAGE, _COMPRESSED), usual))
        name = named.get(f'{side}_camera_info')
        infos.append(choose_topic(bag, name, (_CAMERA_INFO,), (f'/{side}/camera_info',)))
    imu = choose_topic(bag, named.get('imu'), (_IMU,), ('/imu',), is_optional=True)
    return BagTopics((images[0], images[1]), (infos[0], infos[1]), imu)


def read_images(bag: BagReader, topics: BagTopics) -> Iterator[BagImage | BadImage | BagTilt]:
    """Yield images with their calibrations and tilts; bad ones of these are left out, as a node does.

    Raises:
        BagError: the bag is damaged.
    """
    calibrations: dict[str, CameraCalibration] = {}
    wanted = [*topics.images, *topics.camera_infos, *([topics.imu] if topics.imu else [])]
    for raw in bag.messages(wanted):
        message = bag.decode(raw)
        if raw.topic in topics.images:
            side = Side(topics.images.index(raw.topic))
            yield _image(message, raw.msgtype, side, topics, calibrations.get(topics.camera_infos[side]))
            continue
        try:
            if raw.topic == topics.imu:
                yield BagTilt(message.header, tilt_of_imu(message, raw.topic))
            else:
                calibrations.pop(raw.topic, None)
                calibrations[raw.topic] = calibration_from_camera_info(message, raw.topic)
        except MessageError:
            continue  # images tell of a bad calibration


def _image(
    message: Any, msgtype: str, side: Side, topics: BagTopics, calibration: CameraCalibration | None
) -> BagImage | BadImage:
    topic, info_topic = topics.images[side], topics.camera_infos[side]
    stamp_ns = message.header.stamp.sec * _NANOSECONDS + message.header.stamp.nanosec
    try:
        convert = array_from_image if msgtype == _IMAGE else array_from_compressed_image
        pixels = grey(convert(message, topic))
        if calibration is None:
            raise CameraInfoError(f'{topic} came without a usable {info_topic}')
        check_image_size(calibration, pixels.shape, topic, info_topic)
    except MessageError as fault:
        return BadImage(side, stamp_ns, str(fault))
    return BagImage(message.header, side, stamp_ns, pixels, calibration)
