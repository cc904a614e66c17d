"""Where the page has its pairs of images from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from shirube_geometry import CameraMount
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.pair.pair_check import pair_fault
from stereo_landmark.core.pair.rectification import Rectifier
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.teaching_session import StereoImages
from stereo_landmark.files.grey_image import load_grey_image


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


class FilePairs:
    """Pairs of image files.

    Args:
        paths: the left and the right image of each pair.
        calibrations: of the left and of the right camera.
        mount: the left camera's optical frame, as rectified, on the robot.
        rectify: whether the images are raw.
        tilt: roll and pitch of the robot on all of them [rad].

    Raises:
        StereoLandmarkError: the calibrations are no pair's.
    """

    is_live = False

    def __init__(
        self,
        paths: Sequence[tuple[Path, Path]],
        calibrations: tuple[CameraCalibration, CameraCalibration],
        mount: CameraMount,
        *,
        rectify: bool = False,
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.rig = stereo_rig(*calibrations, mount)
        self.labels = [left.name for left, _ in paths]
        self._paths = paths
        self._rectifiers = [Rectifier(each) for each in calibrations] if rectify else None
        self._tilt = tilt
        self._loaded: dict[int, StereoImages] = {}

    def images(self, number: int) -> StereoImages:
        """Return a pair; a file is read once.

        Raises:
            StereoLandmarkError: there is none of that number, or it is no rectified pair.
            ImageFileError: a file is no image.
        """
        check_number(number, len(self._paths))
        if number not in self._loaded:
            left, right = (load_grey_image(path) for path in self._paths[number])
            if self._rectifiers is not None:
                left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
            self._loaded[number] = checked_pair(StereoImages(left, right, self._tilt), self.rig)
        return self._loaded[number]

    def take(self) -> int:
        """Refuse: files are no cameras."""
        raise no_cameras()


def checked_pair(images: StereoImages, rig: StereoRig) -> StereoImages:
    """Return a pair that is one.

    Raises:
        StereoLandmarkError: the images are not rectified, or left and right are swapped.
    """
    fault = pair_fault(images.left, images.right, rig)
    if fault is not None:
        raise StereoLandmarkError(fault.value)
    return images


def check_number(number: int, count: int) -> None:
    """Refuse the number of a pair that is not there.

    Raises:
        StereoLandmarkError: it is not there.
    """
    if not 0 <= number < count:
        raise StereoLandmarkError(f'there is no pair {number + 1}, there are {count}')


def no_cameras() -> StereoLandmarkError:
    """Return what is said when pictures are asked of a source without cameras."""
    return StereoLandmarkError('pictures are taken with --live only; choose one of the pairs')
