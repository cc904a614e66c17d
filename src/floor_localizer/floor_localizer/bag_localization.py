"""A recorded drive through the tracker, as the node would see it, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.located_image import LocatedImage
from shirube_bags.bag_reader import BagReader
from shirube_bags.topic_choice import choose_topic
from shirube_geometry import PinholeCamera
from shirube_ros.camera_info_conversion import camera_from_camera_info, check_image_size
from shirube_ros.image_conversion import array_from_compressed_image, array_from_image
from shirube_ros.message_error import CameraInfoError, MessageError
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.stamp_order import StampOrder

_IMAGE, _COMPRESSED = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage'
_CAMERA_INFO, _ODOMETRY = 'sensor_msgs/msg/CameraInfo', 'nav_msgs/msg/Odometry'
_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class BagTopics:
    """Which topics of a bag are used; an empty name is none."""

    image: str
    camera_info: str
    odometry: str


def choose_topics(
    bag: BagReader, image: str | None, camera_info: str | None, odometry: str | None
) -> BagTopics:
    """Return the topics to use: those that are named, else the node's own, else the only one of the type.

    Raises:
        BagError: a named topic is missing or of another type, or none or several are there to choose from.
    """
    return BagTopics(
        choose_topic(bag, image, (_IMAGE, _COMPRESSED), ('/image_raw', '/image_raw/compressed')),
        choose_topic(bag, camera_info, (_CAMERA_INFO,), ('/camera_info',)),
        choose_topic(bag, odometry, (_ODOMETRY,), ('/odom',), is_optional=True),
    )


class BagLocalization:
    """Feeds a bag's messages to a tracker in their order."""

    def __init__(self, bag: BagReader, topics: BagTopics, create_tracker: Callable[[], FloorTracker]) -> None:
        """Begin without a past.

        Args:
            bag: an open bag.
            topics: which of its topics are used.
            create_tracker: makes the state between images, at the start and after a jump back in time.
        """
        self._bag = bag
        self._topics = topics
        self._create_tracker = create_tracker
        self._tracker = create_tracker()
        self._camera: PinholeCamera | None = None
        self._stamps = StampOrder(self._start_again)

    def run(self) -> Iterator[LocatedImage]:
        """Yield the images with their poses; a bad message is no end, it becomes a result or is left out.

        Raises:
            BagError: the bag is damaged.
        """
        topics = self._topics
        wanted = [name for name in (topics.image, topics.camera_info, topics.odometry) if name]
        for raw in self._bag.messages(wanted):
            message = self._bag.decode(raw)
            if raw.topic == topics.image:
                yield self._locate(message, raw.msgtype)
            elif raw.topic == topics.camera_info:
                self._take_camera_info(message)
            else:
                self._take_odometry(message)

    def _locate(self, message: Any, msgtype: str) -> LocatedImage:
        name, stamp = self._topics.image, message.header.stamp
        stamp_ns = stamp.sec * _NANOSECONDS + stamp.nanosec
        try:
            convert = array_from_image if msgtype == _IMAGE else array_from_compressed_image
            pixels = convert(message, name)
            if self._camera is None:
                raise CameraInfoError(f'{name} came without a usable {self._topics.camera_info}')
            check_image_size(self._camera, pixels.shape, name, self._topics.camera_info)
            seconds = self._stamps.check(message.header, name)
            return LocatedImage(name, stamp_ns, self._tracker.track(seconds, pixels, self._camera))
        except (MessageError, FloorLocalizerError) as fault:
            return LocatedImage(name, stamp_ns, str(fault))

    def _take_camera_info(self, message: Any) -> None:
        self._camera = None
        try:
            self._camera = camera_from_camera_info(message, self._topics.camera_info)
        except MessageError:
            return  # the images that follow tell that there is none

    def _take_odometry(self, message: Any) -> None:
        try:
            T_odom_base = planar_pose(message.pose.pose, self._topics.odometry)
            # First the stamp: if it tells of a jump back, the odometry is the new tracker's.
            stamp = self._stamps.check(message.header, self._topics.odometry)
            self._tracker.add_odometry(stamp, T_odom_base)
        except MessageError:
            return  # as in the node: a bad message is left out

    def _start_again(self) -> None:
        self._tracker = self._create_tracker()
