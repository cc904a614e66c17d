"""Stereo pairs of a bag with the tilt of the base, for teaching."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import TiltBuffer
from shirube_ros.offline.recording import RecordedImage, RecordedTilt, RecordingTopics
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import Side
from stereo_landmark.core.pair.stamp_synchronizer import StampSynchronizer
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.pair_recording import pair_recording

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
            pair = _add_image(synchronizer, message)
            if pair is None:
                continue
            if pending is not None:
                yield _attach_tilt(pending, tilts)
            # Wait for the next IMU reading, which may be nearer than the previous one.
            pending = pair
    if pending is not None:
        yield _attach_tilt(pending, tilts)


def _add_image(synchronizer: StampSynchronizer[_Image], image: _Image) -> tuple[_Image, _Image] | None:
    try:
        return synchronizer.add(Side(image.camera), image.stamp_ns, image)
    except StereoLandmarkError:
        return None  # the caller reports a bag without pairs


def _attach_tilt(pair: tuple[_Image, _Image], tilts: TiltBuffer) -> RecordedPair:
    return RecordedPair(*pair, tilts.tilt_at(pair[0].stamp_ns * 1e-9))
