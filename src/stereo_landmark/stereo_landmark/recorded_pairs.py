"""The pairs of images of a bag, each with the robot's tilt: what a lesson and the teaching page choose from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from shirube_bags.bag_reader import BagReader
from shirube_geometry import TiltTrail
from shirube_recordings.recording import RecordedImage, RecordedTilt
from shirube_recordings.recording_topics import RecordingTopics
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_stream import Side
from stereo_landmark.core.pair.stamp_pairing import StampPairing
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.pair_recording import pair_recording

_QUEUE = 10
"""Images of a camera that wait for their partner."""

_Image = RecordedImage[CameraCalibration]


@dataclass(frozen=True)
class RecordedPair:
    """Both images of a moment, perhaps raw.

    Attributes:
        left: the left one.
        right: the right one.
        tilt: roll and pitch of the base that the imu told near it [rad], None where it told none.
    """

    left: _Image
    right: _Image
    tilt: tuple[float, float] | None


def recorded_pairs(
    bag: BagReader, topics: RecordingTopics, tolerance: float, begin_ns: int | None = None
) -> Iterator[RecordedPair]:
    """Yield the pairs of a bag; images without a partner are left out, as cameras need not start together.

    Args:
        bag: an open bag.
        topics: which of its topics are used.
        tolerance: stamps of a pair differ by no more [s].
        begin_ns: older images are left out [ns]; None for none.

    Raises:
        BagError: the bag is damaged.
    """
    waiting: StampPairing[_Image] = StampPairing(round(tolerance * 1e9), _QUEUE)
    tilts = TiltTrail()
    held: tuple[_Image, _Image] | None = None
    for message in pair_recording(bag, topics).messages():
        if isinstance(message, RecordedTilt):
            tilts.add(message.stamp_ns * 1e-9, *message.tilt)
            if held is not None and message.stamp_ns >= held[0].stamp_ns:
                yield _with_tilt(held, tilts)
                held = None
        elif isinstance(message, RecordedImage) and (begin_ns is None or message.stamp_ns >= begin_ns):
            pair = _completed(waiting, message)
            if pair is None:
                continue
            if held is not None:
                yield _with_tilt(held, tilts)
            # The reading of the imu that comes after it may be nearer than the one before.
            held = pair
    if held is not None:
        yield _with_tilt(held, tilts)


def _completed(waiting: StampPairing[_Image], image: _Image) -> tuple[_Image, _Image] | None:
    try:
        return waiting.add(Side(image.camera), image.stamp_ns, image)
    except StereoLandmarkError:
        return None  # whoever gets no pair at all complains


def _with_tilt(pair: tuple[_Image, _Image], tilts: TiltTrail) -> RecordedPair:
    return RecordedPair(*pair, tilts.tilt_at(pair[0].stamp_ns * 1e-9))
