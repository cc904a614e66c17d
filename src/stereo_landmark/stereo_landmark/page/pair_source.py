"""Where the page has its pairs of images from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_check import pair_fault
from stereo_landmark.core.pair.rectification import Rectifier
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


class PairSource(Protocol):
    """Pairs of images, numbered from 0; a number always gives the same pair."""

    @property
    def rig(self) -> StereoRig:
        """The rectified cameras."""

    @property
    def labels(self) -> Sequence[str]:
        """What each pair is called on the page."""

    @property
    def is_live(self) -> bool:
        """Whether `take` adds pairs."""

    def images(self, number: int) -> StereoImages:
        """Return a pair.

        Raises:
            StereoLandmarkError: there is none of that number, or it is no rectified pair.
        """

    def take(self) -> int:
        """Add what the cameras see now and return its number.

        Raises:
            StereoLandmarkError: there are no cameras, or they are silent.
        """


class RecordedPairs:
    """Pairs that were taken before.

    Args:
        labels: what each pair is called.
        read: gives the left and the right image of a number, each of shape (h, w), raw or rectified, and the tilt.
        rig: the rectified cameras.
        raw: calibrations of the left and of the right camera where the images come raw, else None.
    """

    is_live = False

    def __init__(
        self,
        labels: Sequence[str],
        read: Callable[[int], StereoImages],
        rig: StereoRig,
        raw: tuple[CameraCalibration, CameraCalibration] | None = None,
    ) -> None:
        self.rig = rig
        self.labels = labels
        self._read = read
        self._rectifiers = [Rectifier(each) for each in raw or ()]
        self._ready: dict[int, StereoImages] = {}

    def images(self, number: int) -> StereoImages:
        """Return a pair, rectified; it is read once.

        Raises:
            StereoLandmarkError: there is none of that number, or it is no rectified pair.
            CameraFileError: a file is no image.
        """
        if not 0 <= number < len(self.labels):
            raise StereoLandmarkError(f'there is no pair {number + 1}, there are {len(self.labels)}')
        if number not in self._ready:
            self._ready[number] = self._rectified(self._read(number))
        return self._ready[number]

    def take(self) -> int:
        """Refuse: what was recorded is no camera.

        Raises:
            StereoLandmarkError: always.
        """
        raise StereoLandmarkError('pictures are taken with --live only; choose one of the pairs')

    def _rectified(self, pair: StereoImages) -> StereoImages:
        left, right = pair.left, pair.right
        if self._rectifiers:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        fault = pair_fault(left, right, self.rig)
        if fault is not None:
            raise StereoLandmarkError(fault.value)
        return StereoImages(left, right, pair.tilt)
