"""Sources of stereo pairs for the page: files, bags and edited places."""

import argparse
import math
from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import CameraMount
from shirube_ros.camera.image import to_grey
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, stereo_rig
from stereo_landmark.core.pair.rectification_check import PairCheck, check_pair
from stereo_landmark.core.stereo import StereoImages, StereoRig, calibration_hash
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import RecordedPair, choose_topics, load_grey_image, pair_files, recorded_pairs
from stereo_landmark.files.place_file import load_images, load_place


class StereoPairs:
    """Recorded stereo pairs, numbered from 0; a number always returns the same pair.

    Args:
        labels: label of each pair.
        read: function that returns the raw or rectified pair of a number.
        rig: rectified stereo cameras.
        raw: calibrations of the left and right camera to rectify raw images, otherwise None.
    """

    is_live = False
    """Whether `capture` adds pairs."""

    def __init__(
        self,
        labels: Sequence[str],
        read: Callable[[int], StereoImages],
        rig: StereoRig,
        raw: tuple[CameraCalibration, CameraCalibration] | None = None,
    ) -> None:
        self.rig = rig
        self.check = PairCheck(0)  # of the latest pair
        self.labels = labels
        self._read = read
        self._rectifiers = [Rectifier(each) for each in raw or ()]
        self._ready: dict[int, StereoImages] = {}

    def images(self, number: int) -> StereoImages:
        """Return a rectified pair, from the cache after the first call.

        Raises:
            StereoLandmarkError: the number does not exist, or the pair is not rectified.
            CameraFileError: a file is not an image.
        """
        if not 0 <= number < len(self.labels):
            raise StereoLandmarkError(f'there is no pair {number + 1}, there are {len(self.labels)}')
        if number not in self._ready:
            self._ready[number] = self._rectify(self._read(number))
        return self._ready[number]

    def capture(self) -> int:
        """Capture a pair from the live cameras and return its number.

        Raises:
            StereoLandmarkError: there are no live cameras, or no images are received.
        """
        raise StereoLandmarkError('pairs can be captured with --live only; select one of the recorded pairs')

    def _rectify(self, pair: StereoImages) -> StereoImages:
        left, right = pair.left, pair.right
        if self._rectifiers:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        self.check = check_pair(left, right, self.rig)
        if self.check.fault is not None:
            raise StereoLandmarkError(self.check.summary)
        return StereoImages(left, right, pair.tilt)


def file_pairs(options: argparse.Namespace, mount: CameraMount) -> StereoPairs:
    """Return the stereo pairs of the image files in the options.

    Raises:
        StereoLandmarkError: files are missing, or the calibrations are not those of a stereo pair.
        CameraFileError: a file is malformed.
    """
    files, (left, right) = pair_files(options)
    roll, pitch = options.tilt

    def read(number: int) -> StereoImages:
        left_file, right_file = files[number]
        return StereoImages(load_grey_image(left_file), load_grey_image(right_file), (roll, pitch))

    raw = (left, right) if options.rectify else None
    return StereoPairs([path.name for path, _ in files], read, stereo_rig(left, right, mount), raw)


PAIRS_MAX = 60
"""Maximum number of offered pairs; longer bags are subsampled."""


def bag_pairs(options: argparse.Namespace, mount: CameraMount) -> StereoPairs:
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
    return StereoPairs(labels, read, stereo_rig(*calibrations, mount), raw)


def _read(options: argparse.Namespace) -> list[RecordedPair]:
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, vars(options), is_raw=options.rectify)
        total = bag.topics[topics.images[0]].message_count
        pairs = recorded_pairs(bag, topics, options.approximate_sync or 0.0)
        shown = tqdm(pairs, total=total, unit='pair', delay=1.0, disable=None)
        step = max(1, math.ceil(total / PAIRS_MAX))
        return list(islice(shown, None, None, step))


def join_pairs(first: StereoPairs, others: Sequence[tuple[str, StereoPairs]]) -> StereoPairs:
    """Return pairs of several bags: a place taught in one can be tested on the others.

    Args:
        first: first pairs, which keep their numbers.
        others: further pairs, each with the name of its bag.

    Raises:
        StereoLandmarkError: a bag was recorded with other cameras.
    """
    numbered = [(first, number) for number in range(len(first.labels))]
    labels = list(first.labels)
    for name, other in others:
        if calibration_hash(other.rig) != calibration_hash(first.rig):
            raise StereoLandmarkError(f'{name} was recorded with other cameras; give a bag with the same calibration')
        numbered += [(other, number) for number in range(len(other.labels))]
        labels += [f'{name} {label}' for label in other.labels]

    def read(number: int) -> StereoImages:
        source, of_source = numbered[number]
        return source.images(of_source)

    return StereoPairs(labels, read, first.rig)


def taught_pair(path: Path) -> StereoPairs:
    """Return the stereo pair used for teaching a place.

    Raises:
        LandmarkFileError: the place is malformed.
    """
    images = load_images(path)
    return StereoPairs(['as taught'], lambda _: images, load_place(path).rig)
