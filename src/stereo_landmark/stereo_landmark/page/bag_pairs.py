"""Stereo pairs of a bag for the page."""

from __future__ import annotations

import argparse
import math
from itertools import islice

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import CameraMount
from stereo_landmark.core.pair.camera_calibration import stereo_rig
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.grey_image import to_grey
from stereo_landmark.page.pair_source import RecordedPairs
from stereo_landmark.pair_recording import choose_topics
from stereo_landmark.recorded_pairs import RecordedPair, recorded_pairs

PAIRS_MAX = 60
"""Maximum number of offered pairs; longer bags are subsampled."""


def bag_pairs(options: argparse.Namespace, mount: CameraMount) -> RecordedPairs:
    """Return stereo pairs of a bag, evenly distributed over time.

    Raises:
        StereoLandmarkError: there are no pairs, or the calibrations are not those of a stereo pair.
        BagError: the bag is malformed, or topics are missing.
    """
    pairs = _read(options)
    if not pairs:
        raise StereoLandmarkError(
            f'{options.bag}: left and right images have no common stamps; give --approximate-sync'
        )
    calibrations = pairs[0].left.calibration, pairs[0].right.calibration
    pairs = [pair for pair in pairs if (pair.left.calibration, pair.right.calibration) == calibrations]
    seconds = [pair.left.stamp_ns * 1e-9 for pair in pairs]

    def read(number: int) -> StereoImages:
        pair = pairs[number]
        tilt = tuple(options.tilt) if pair.tilt is None else pair.tilt
        return StereoImages(to_grey(pair.left.pixels), to_grey(pair.right.pixels), tilt)

    labels = [f'{each - seconds[0]:.1f} s' for each in seconds]
    raw = calibrations if options.rectify else None
    return RecordedPairs(labels, read, stereo_rig(*calibrations, mount), raw)


def _read(options: argparse.Namespace) -> list[RecordedPair]:
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, vars(options), is_raw=options.rectify)
        total = bag.topics[topics.images[0]].message_count
        pairs = recorded_pairs(bag, topics, options.approximate_sync or 0.0)
        shown = tqdm(pairs, total=total, unit='pair', delay=1.0, disable=None)
        step = max(1, math.ceil(total / PAIRS_MAX))
        return list(islice(shown, None, None, step))
