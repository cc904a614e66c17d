"""A recorded drive through the localizer, as the node would see it, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from shirube_bags.bag_reader import BagReader
from shirube_bags.topic_choice import choose_topic
from shirube_ros.camera_info_conversion import check_image_size
from shirube_ros.image_conversion import array_from_compressed_image, array_from_image
from shirube_ros.message_error import CameraInfoError, MessageError
from shirube_ros.stamp_order import StampOrder
from shirube_ros.tilt_conversion import tilt_of_imu
from stereo_landmark.calibration_message import calibration_from_camera_info
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import PairStream, Side
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.grey_image import grey
from stereo_landmark.located_frame import LocatedFrame

_IMAGE, _COMPRESSED = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'
_CAMERA_INFO, _IMU = 'sensor_msgs/msg/CameraInfo', 'sensor_msgs/msg/Imu'
_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class SideTopics:
    """Topics of one camera."""

    image: str
    camera_info: str


@dataclass(frozen=True)
class BagTopics:
    """Which topics of a bag are used.

    Attributes:
        sides: of the left and of the right camera.
        imu: empty for none.
    """

    sides: tuple[SideTopics, SideTopics]
    imu: str


def choose_topics(bag: BagReader, named: dict[str, str | None]) -> BagTopics:
    """Return the topics to use: those that are named, else the usual ones.

    Args:
        bag: an open bag.
        named: by ``left_image``, ``left_camera_info``, ``right_image``, ``right_camera_info`` and ``imu``.

    Raises:
        BagError: a named topic is missing or of another type, or there is none, or several, to choose from.
    """
    sides = []
    for side in ('left', 'right'):
        usual = tuple(
            f'/{side}/{name}{end}' for name in ('image_rect', 'image_raw') for end in ('', '/compressed')
        )
        image = choose_topic(bag, named.get(f'{side}_image'), (_IMAGE, _COMPRESSED), usual)
        info = choose_topic(bag, named.get(f'{side}_camera_info'), (_CAMERA_INFO,), (f'/{side}/camera_info',))
        sides.append(SideTopics(image, info))
    imu = choose_topic(bag, named.get('imu'), (_IMU,), ('/imu',), is_optional=True)
    return BagTopics((sides[0], sides[1]), imu)


class BagLocalization:
    """Feeds a bag's messages to a localizer in their order."""

    def __init__(self, bag: BagReader, topics: BagTopics, create_stream: Callable[[], PairStream]) -> None:
        """Begin without a past.

        Args:
            bag: an open bag.
            topics: which of its topics are used.
            create_stream: makes the state between images, at the start and after a jump back in time.
        """
        self._bag = bag
        self._topics = topics
        self._create_stream = create_stream
        self._stream = create_stream()
        self._calibrations: dict[str, CameraCalibration] = {}
        self._stamps = StampOrder(self._start_again)

    def run(self) -> Iterator[LocatedFrame]:
        """Yield pairs with their results; a bad message is no end, it becomes a result or is left out.

        Raises:
            BagError: the bag is damaged.
        """
        sides = {side.image: number for number, side in enumerate(self._topics.sides)}
        infos = {side.camera_info for side in self._topics.sides}
        wanted = [*sides, *infos, *([self._topics.imu] if self._topics.imu else [])]
        for raw in self._bag.messages(wanted):
            message = self._bag.decode(raw)
            if raw.topic in sides:
                frame = self._frame(message, raw.msgtype, Side(sides[raw.topic]))
                if frame is not None:
                    yield frame
                continue
            try:
                self._take(message, raw.topic)
            except MessageError:
                continue  # as in the node: a bad message is left out, and images tell of a bad calibration

    def _frame(self, message: Any, msgtype: str, side: Side) -> LocatedFrame | None:
        topics, stamp = self._topics.sides[side], message.header.stamp
        stamp_ns = stamp.sec * _NANOSECONDS + stamp.nanosec
        try:
            convert = array_from_image if msgtype == _IMAGE else array_from_compressed_image
            pixels = grey(convert(message, topics.image))
            calibration = self._calibrations.get(topics.camera_info)
            if calibration is None:
                raise CameraInfoError(f'{topics.image} came without a usable {topics.camera_info}')
            check_image_size(calibration, pixels.shape, topics.image, topics.camera_info)
            self._stamps.check(message.header, topics.image)
            located = self._stream.add_image(side, stamp_ns, pixels, calibration)
        except (MessageError, StereoLandmarkError) as fault:
            return LocatedFrame(topics.image, stamp_ns, str(fault))
        return None if located is None else LocatedFrame(topics.image, located.stamp_ns, located)

    def _take(self, message: Any, topic: str) -> None:
        if topic == self._topics.imu:
            roll, pitch = tilt_of_imu(message, topic)
            self._stream.add_tilt(self._stamps.check(message.header, topic), roll, pitch)
            return
        self._calibrations.pop(topic, None)
        self._calibrations[topic] = calibration_from_camera_info(message, topic)

    def _start_again(self) -> None:
        self._stream = self._create_stream()
