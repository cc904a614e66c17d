"""A recorded drive through the localizer, as the node would see it, without ROS running."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from shirube_bags.bag_reader import BagReader
from shirube_ros.message_error import MessageError
from shirube_ros.stamp_order import StampOrder
from stereo_landmark.bag_images import BadImage, BagImage, BagTilt, BagTopics, read_images
from stereo_landmark.core.pair.pair_stream import PairStream, Side
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.located_frame import LocatedFrame


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
        self._stamps = StampOrder(self._start_again)

    def run(self) -> Iterator[LocatedFrame]:
        """Yield pairs with their results; a bad message is no end, it becomes a result or is left out.

        Raises:
            BagError: the bag is damaged.
        """
        for message in read_images(self._bag, self._topics):
            if isinstance(message, BagImage):
                frame = self._frame(message)
                if frame is not None:
                    yield frame
            elif isinstance(message, BadImage):
                yield LocatedFrame(self._topics.images[message.side], message.stamp_ns, message.fault)
            else:
                self._take_tilt(message)

    def _frame(self, image: BagImage) -> LocatedFrame | None:
        topic = self._topics.images[image.side]
        try:
            self._stamps.check(image.header, topic)
            located = self._stream.add_image(image.side, image.stamp_ns, image.pixels, image.calibration)
        except (MessageError, StereoLandmarkError) as fault:
            return LocatedFrame(topic, image.stamp_ns, str(fault))
        if located is None:
            return None
        return LocatedFrame(self._topics.images[Side.LEFT], located.stamp_ns, located)

    def _take_tilt(self, message: BagTilt) -> None:
        try:
            stamp = self._stamps.check(message.header, self._topics.imu)
        except MessageError:
            return
        self._stream.add_tilt(stamp, *message.tilt)

    def _start_again(self) -> None:
        self._stream = self._create_stream()
