"""Pairs of a recorded drive for the page."""

from __future__ import annotations

import argparse
import math

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_geometry import CameraMount, TiltTrail
from shirube_recordings.recording import RecordedImage, RecordedTilt
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.pair.pair_stream import Side
from stereo_landmark.core.pair.stamp_pairing import StampPairing
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.teaching_session import StereoImages
from stereo_landmark.files.grey_image import grey
from stereo_landmark.page.pair_source import RecordedPairs
from stereo_landmark.pair_recording import choose_topics, pair_recording

PAIRS_MAX = 60
"""Of a longer drive every so many pairs one is offered."""
_QUEUE = 10
"""Images of a camera that wait for their partner."""

_Image = RecordedImage[CameraCalibration]
_Pair = tuple[_Image, _Image]


def bag_pairs(options: argparse.Namespace, mount: CameraMount) -> RecordedPairs:
    """Return pairs of a bag, evenly over its time.

    Raises:
        StereoLandmarkError: there are no pairs, or their calibrations are no pair's.
        BagError: the bag cannot be read, or topics are missing.
    """
    pairs, tilts = _read(options)
    if not pairs:
        raise StereoLandmarkError(
            f'{options.bag}: left and right images have no stamps in common; give --approximate-sync'
        )
    calibrations = pairs[0][0].calibration, pairs[0][1].calibration
    pairs = [pair for pair in pairs if (pair[0].calibration, pair[1].calibration) == calibrations]
    seconds = [pair[0].stamp_ns * 1e-9 for pair in pairs]

    def read(number: int) -> StereoImages:
        left, right = pairs[number]
        tilt = tilts.tilt_at(seconds[number]) or tuple(options.tilt)
        return StereoImages(grey(left.pixels), grey(right.pixels), tilt)

    labels = [f'{each - seconds[0]:.1f} s' for each in seconds]
    raw = calibrations if options.rectify else None
    return RecordedPairs(labels, read, stereo_rig(*calibrations, mount), raw)


def _read(options: argparse.Namespace) -> tuple[list[_Pair], TiltTrail]:
    waiting: StampPairing[_Image] = StampPairing(round((options.approximate_sync or 0.0) * 1e9), _QUEUE)
    tilts, pairs, count = TiltTrail(), list[_Pair](), 0
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, vars(options), is_raw=options.rectify)
        total = bag.topics[topics.images[0]].message_count
        step = math.ceil(total / PAIRS_MAX)
        with tqdm(total=total, unit='pair', delay=1.0, disable=None) as progress:
            for message in pair_recording(bag, topics).messages():
                if isinstance(message, RecordedTilt):
                    tilts.add(message.stamp_ns * 1e-9, *message.tilt)
                if not isinstance(message, RecordedImage):
                    continue
                pair = waiting.add(Side(message.camera), message.stamp_ns, message)
                if pair is None:
                    continue
                progress.update()
                if count % step == 0:
                    pairs.append(pair)
                count += 1
    return pairs, tilts
