"""The messages of a bag as a localizer's node receives them, without ROS running."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagMessage, BagReader
from shirube_bags.errors import BagError
from shirube_bags.stamps import NANOSECONDS
from shirube_core.geometry import SE2
from shirube_ros.camera.image import array_from_compressed_image, array_from_image
from shirube_ros.camera.info import SizedCamera, check_image_size
from shirube_ros.errors import CameraInfoError, MessageError
from shirube_ros.message_conversion import planar_pose, tilt_from_imu

_IMAGES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')


@dataclass(frozen=True)
class RecordingTopics:
    """Topics, empty for none: images, their calibrations in the same order, odometry and IMU (tilt)."""

    images: tuple[str, ...]
    camera_infos: tuple[str, ...]
    odometry: str = ''
    imu: str = ''

    @property
    def wanted(self) -> list[str]:
        """All topics that are not empty."""
        return [name for name in (*self.images, *self.camera_infos, self.odometry, self.imu) if name]


def choose_images(
    bag: BagReader, name: str | None, default: tuple[str, ...] = ('/image_raw', '/image_raw/compressed')
) -> str:
    """Return the image topic of a camera; see `select_topic`."""
    return select_topic(bag, name, _IMAGES, default)


def choose_camera_info(bag: BagReader, name: str | None, default: str = '/camera_info') -> str:
    """Return the CameraInfo topic of a camera; see `select_topic`."""
    return select_topic(bag, name, ('sensor_msgs/msg/CameraInfo',), (default,))


def choose_imu(bag: BagReader, name: str | None) -> str:
    """Return the IMU topic, empty if there is none; see `select_topic`."""
    return select_topic(bag, name, ('sensor_msgs/msg/Imu',), ('/imu',), is_optional=True)


def choose_topics(
    bag: BagReader, image: str | None, camera_info: str | None, odometry: str | None, imu: str | None = ''
) -> RecordingTopics:
    """Return the topics of one camera by `select_topic`; None means not given, an empty ``imu`` is not used.

    Raises:
        BagError: a given topic is missing or of another type, or the choice is not unique.
    """
    return RecordingTopics(
        (choose_images(bag, image),),
        (choose_camera_info(bag, camera_info),),
        select_topic(bag, odometry, ('nav_msgs/msg/Odometry',), ('/odom',), is_optional=True),
        '' if imu == '' else choose_imu(bag, imu),
    )


def select_topic(
    bag: BagReader, name: str | None, types: tuple[str, ...], defaults: tuple[str, ...], *, is_optional: bool = False
) -> str:
    """Return the named topic, else the first default one, else the only one of the types, else an empty one.

    Raises:
        BagError: the named topic is missing or has another type, or the choice is not unique.
    """
    matching = sorted(topic.name for topic in bag.topics.values() if topic.msgtype in types)
    kind = types[0].rpartition('/')[2]
    if name is not None:
        (name,) = bag.select_topics([name])
        if name not in matching:
            raise BagError(f'{bag.path}: topic {name} is {bag.topics[name].msgtype}, no {kind}')
        return name
    candidates = [topic for topic in defaults if topic in matching] or matching
    if candidates and (len(matching) == 1 or candidates[0] in defaults):
        return candidates[0]
    if is_optional:
        return ''
    if not matching:
        raise BagError(f'{bag.path}: has no topic of type {kind}; it has {", ".join(sorted(bag.topics))}')
    raise BagError(f'{bag.path}: has several topics of type {kind}; name one of {", ".join(matching)}')


Calibration = TypeVar('Calibration', bound=SizedCamera)


@dataclass(frozen=True)
class RecordedImage(Generic[Calibration]):
    """A recorded image of shape (h, w) or (h, w, 3), with stamp [ns], index and calibration of its camera."""

    camera: int
    topic: str
    header: Any
    stamp_ns: int
    pixels: NDArray[np.uint8]
    calibration: Calibration


@dataclass(frozen=True)
class BadImage:
    """An image that cannot be used, with stamp [ns] and an error message of one line."""

    topic: str
    stamp_ns: int
    fault: str


@dataclass(frozen=True)
class RecordedOdometry:
    """A recorded pose of the base in the odometry frame."""

    topic: str
    header: Any
    T_odom_base: SE2


@dataclass(frozen=True)
class RecordedTilt:
    """A recorded tilt, roll and pitch of the base [rad], with its stamp [ns]."""

    topic: str
    header: Any
    stamp_ns: int
    tilt: tuple[float, float]


class Recording(Generic[Calibration]):
    """Reads topics of an open bag; invalid messages are skipped, as a node skips them."""

    def __init__(
        self, bag: BagReader, topics: RecordingTopics, read_calibration: Callable[[Any, str], Calibration]
    ) -> None:
        self._bag, self._topics, self._read_calibration = bag, topics, read_calibration
        self._calibrations: dict[str, Calibration] = {}

    def messages(self) -> Iterator[RecordedImage[Calibration] | BadImage | RecordedOdometry | RecordedTilt]:
        """Yield the converted messages in order; an invalid image is yielded with its error.

        Raises:
            BagError: the bag is corrupted.
        """
        for raw in self._bag.messages(self._topics.wanted):
            message = self._bag.decode(raw)
            if raw.topic in self._topics.images:
                yield self._image(message, raw)
                continue
            try:
                if raw.topic == self._topics.odometry:
                    yield RecordedOdometry(raw.topic, message.header, planar_pose(message.pose.pose, raw.topic))
                elif raw.topic == self._topics.imu:
                    tilt = tilt_from_imu(message, raw.topic)
                    yield RecordedTilt(raw.topic, message.header, _stamp_ns(message), tilt)
                else:
                    self._calibrations.pop(raw.topic, None)
                    self._calibrations[raw.topic] = self._read_calibration(message, raw.topic)
            except MessageError:
                continue  # a bad calibration is reported with each image

    def _image(self, message: Any, raw: BagMessage) -> RecordedImage[Calibration] | BadImage:
        camera = self._topics.images.index(raw.topic)
        info_topic = self._topics.camera_infos[camera]
        stamp_ns = _stamp_ns(message)
        is_compressed = raw.msgtype.endswith('CompressedImage')
        try:
            pixels = (array_from_compressed_image if is_compressed else array_from_image)(message, raw.topic)
            calibration = self._calibrations.get(info_topic)
            if calibration is None:
                raise CameraInfoError(f'{raw.topic} was received without a valid {info_topic}')
            check_image_size(calibration, pixels.shape, raw.topic, info_topic)
        except MessageError as fault:
            return BadImage(raw.topic, stamp_ns, str(fault))
        return RecordedImage(camera, raw.topic, message.header, stamp_ns, pixels, calibration)


def _stamp_ns(message: Any) -> int:
    return int(message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec)
