"""Localization from a bag, with the same tracker as the node, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.files.pose_table import LocatedImage
from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera_info_conversion import camera_from_camera_info
from shirube_ros.message_error import MessageError
from shirube_ros.recording import BadImage, RecordedImage, RecordedOdometry, Recording
from shirube_ros.recording_topics import RecordingTopics, choose_camera_info, choose_images, choose_odometry
from shirube_ros.stamp_validator import StampValidator


def choose_topics(
    bag: BagReader, image: str | None, camera_info: str | None, odometry: str | None
) -> RecordingTopics:
    """Return the topics to use: the given ones, else the node's defaults, else the only one of the type.

    Raises:
        BagError: a given topic is missing or of another type, or there are no or several candidates.
    """
    images, camera_infos = choose_images(bag, image), choose_camera_info(bag, camera_info)
    return RecordingTopics((images,), (camera_infos,), choose_odometry(bag, odometry))


class BagLocalization:
    """Feeds a bag's messages to a tracker in order."""

    def __init__(
        self, bag: BagReader, topics: RecordingTopics, create_tracker: Callable[[], FloorTracker]
    ) -> None:
        """Start with a new tracker.

        Args:
            bag: an open bag.
            topics: topics to use.
            create_tracker: creates the tracker, at the start and after a jump back in time.
        """
        self._recording = Recording(bag, topics, camera_from_camera_info)
        self._create_tracker = create_tracker
        self._tracker = create_tracker()
        self._stamps = StampValidator(self._reset)

    def run(self) -> Iterator[LocatedImage]:
        """Yield the images with their poses; a malformed message is reported as a result or skipped.

        Raises:
            BagError: the bag is corrupted.
        """
        for message in self._recording.messages():
            match message:
                case RecordedImage():
                    yield self._locate(message)
                case BadImage():
                    yield LocatedImage(message.topic, message.stamp_ns, message.fault)
                case RecordedOdometry():
                    self._add_odometry(message)

    def _locate(self, image: RecordedImage[PinholeCamera]) -> LocatedImage:
        try:
            seconds = self._stamps.check(image.header, image.topic)  # may create a new tracker
            result = self._tracker.track(seconds, image.pixels, image.calibration)
            return LocatedImage(image.topic, image.stamp_ns, result)
        except (MessageError, FloorLocalizerError) as fault:
            return LocatedImage(image.topic, image.stamp_ns, str(fault))

    def _add_odometry(self, odometry: RecordedOdometry) -> None:
        try:
            # The stamp first: after a jump back in time, the odometry belongs to the new tracker.
            stamp = self._stamps.check(odometry.header, odometry.topic)
        except MessageError:
            return  # as in the node, a malformed message is skipped
        self._tracker.add_odometry(stamp, odometry.T_odom_base)

    def _reset(self) -> None:
        self._tracker = self._create_tracker()
