"""Process a recorded bag with the receiver as the node would, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera_info_conversion import camera_from_camera_info
from shirube_ros.message_error import MessageError
from shirube_ros.recording import BadImage, RecordedImage, RecordedOdometry, RecordedTilt, Recording
from shirube_ros.recording_topics import (
    RecordingTopics,
    choose_camera_info,
    choose_images,
    choose_imu,
    choose_odometry,
)
from shirube_ros.stamp_validator import StampValidator
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.pose_table import LocatedImage


def choose_topics(
    bag: BagReader, image: str | None, camera_info: str | None, odometry: str | None, imu: str | None
) -> RecordingTopics:
    """Return the topics to use: the named ones, else the node's defaults, else the only topic of the type.

    Raises:
        BagError: a named topic is missing or has another type, or the choice is not unique.
    """
    images, camera_infos = choose_images(bag, image), choose_camera_info(bag, camera_info)
    return RecordingTopics((images,), (camera_infos,), choose_odometry(bag, odometry), choose_imu(bag, imu))


class BagLocalization:
    """Feeds a bag's messages to a receiver in recorded order."""

    def __init__(
        self, bag: BagReader, topics: RecordingTopics, create_receiver: Callable[[], BeaconReceiver]
    ) -> None:
        """Create the receiver.

        Args:
            bag: an open bag.
            topics: topics to read.
            create_receiver: factory of the receiver, called at the start and after a jump back in time.
        """
        self._recording = Recording(bag, topics, camera_from_camera_info)
        self._create_receiver = create_receiver
        self._receiver = create_receiver()
        self._stamps = StampValidator(self._reset)

    def run(self) -> Iterator[LocatedImage]:
        """Yield the images with their results; malformed messages are reported as results or skipped.

        Raises:
            BagError: the bag is corrupted.
        """
        for message in self._recording.messages():
            match message:
                case RecordedImage():
                    yield self._locate(message)
                case BadImage():
                    yield LocatedImage(message.topic, message.stamp_ns, message.fault)
                case _:
                    self._add_measurement(message)

    def _locate(self, image: RecordedImage[PinholeCamera]) -> LocatedImage:
        try:
            seconds = self._stamps.check(image.header, image.topic)  # may replace the receiver
            result = self._receiver.receive(seconds, image.pixels, image.calibration)
            return LocatedImage(image.topic, image.stamp_ns, result)
        except (MessageError, VlcBeaconError) as fault:
            return LocatedImage(image.topic, image.stamp_ns, str(fault))

    def _add_measurement(self, message: RecordedOdometry | RecordedTilt) -> None:
        try:
            # Check the stamp first: after a jump back in time the message goes to the new receiver.
            stamp = self._stamps.check(message.header, message.topic)
        except MessageError:
            return  # as in the node: malformed messages are skipped
        if isinstance(message, RecordedTilt):
            self._receiver.add_tilt(stamp, *message.tilt)
        else:
            self._receiver.add_odometry(stamp, message.T_odom_base)

    def _reset(self) -> None:
        self._receiver = self._create_receiver()
