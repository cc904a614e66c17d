"""Localization of a recorded bag, with the same pipeline as the node, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from shirube_bags.bag_reader import BagReader
from shirube_ros.message_error import MessageError
from shirube_ros.recording import BadImage, RecordedImage, RecordedTilt
from shirube_ros.recording_topics import RecordingTopics
from shirube_ros.stamp_validator import StampValidator
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import PairStream, Side
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import to_grey
from stereo_landmark.files.displacement_files import LocatedFrame
from stereo_landmark.files.recording import pair_recording


class BagLocalization:
    """Feeds the messages of a bag to the localizer in recorded order."""

    def __init__(
        self, bag: BagReader, topics: RecordingTopics, create_stream: Callable[[], PairStream]
    ) -> None:
        """Start with a new localizer.

        Args:
            bag: open bag.
            topics: topics of the bag to use.
            create_stream: factory of the localizer, called at the start and after a jump back in time.
        """
        self._recording = pair_recording(bag, topics)
        self._left_topic = topics.images[Side.LEFT]
        self._create_stream = create_stream
        self._stream = create_stream()
        self._stamps = StampValidator(self._reset_stream)

    def run(self) -> Iterator[LocatedFrame]:
        """Yield the result of each pair; a malformed image yields its error, other malformed messages are skipped.

        Raises:
            BagError: the bag is corrupted.
        """
        for message in self._recording.messages():
            match message:
                case RecordedImage():
                    frame = self._process_image(message)
                    if frame is not None:
                        yield frame
                case BadImage():
                    yield LocatedFrame(message.topic, message.stamp_ns, message.fault)
                case RecordedTilt():
                    self._add_tilt(message)

    def _process_image(self, image: RecordedImage[CameraCalibration]) -> LocatedFrame | None:
        try:
            self._stamps.check(image.header, image.topic)
            located = self._stream.add_image(
                Side(image.camera), image.stamp_ns, to_grey(image.pixels), image.calibration
            )
        except (MessageError, StereoLandmarkError) as fault:
            return LocatedFrame(image.topic, image.stamp_ns, str(fault))
        if located is None:
            return None
        return LocatedFrame(self._left_topic, located.stamp_ns, located)

    def _add_tilt(self, message: RecordedTilt) -> None:
        try:
            stamp = self._stamps.check(message.header, message.topic)
        except MessageError:
            return  # as in the node: malformed messages are skipped
        self._stream.add_tilt(stamp, *message.tilt)

    def _reset_stream(self) -> None:
        self._stream = self._create_stream()
