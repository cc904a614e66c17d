"""Sources of stereo pairs for the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.epipolar_check import pair_fault
from stereo_landmark.core.pair.rectification import Rectifier
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


class PairSource(Protocol):
    """Stereo pairs, numbered from 0; a number always returns the same pair."""

    @property
    def rig(self) -> StereoRig:
        """The rectified cameras."""

    @property
    def labels(self) -> Sequence[str]:
        """Label of each pair on the page."""

    @property
    def is_live(self) -> bool:
        """Whether `capture` adds pairs."""

    def images(self, number: int) -> StereoImages:
        """Return a pair.

        Raises:
            StereoLandmarkError: the number does not exist, or the pair is not rectified.
        """

    def capture(self) -> int:
        """Capture a pair from the live cameras and return its number.

        Raises:
            StereoLandmarkError: there are no live cameras, or no images are received.
        """


class RecordedPairs:
    """Recorded pairs.

    Args:
        labels: label of each pair.
        read: function that returns the raw or rectified pair of a number.
        rig: rectified stereo cameras.
        raw: calibrations of the left and right camera to rectify raw images, otherwise None.
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
        """Raise an error: recorded pairs have no live camera.

        Raises:
            StereoLandmarkError: always.
        """
        raise StereoLandmarkError('pairs can be captured with --live only; select one of the recorded pairs')

    def _rectify(self, pair: StereoImages) -> StereoImages:
        left, right = pair.left, pair.right
        if self._rectifiers:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        fault = pair_fault(left, right, self.rig)
        if fault is not None:
            raise StereoLandmarkError(fault.value)
        return StereoImages(left, right, pair.tilt)
