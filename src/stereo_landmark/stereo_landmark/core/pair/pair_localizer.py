"""Pairs of images, one after another, to where the robot is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer, LandmarkSettings
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.pair.pair_check import pair_fault
from stereo_landmark.core.pair.rectification import Rectifier
from stereo_landmark.core.pair.same_cameras import check_cameras
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

REMEMBERED = 10.0
"""A robot that was at a place so lately is probably still there [s]."""

CHECK_INTERVAL = 2.0
"""Cameras that were a rectified pair so lately still are one [s]."""


@dataclass(frozen=True)
class LocatedPair:
    """What a pair of images told.

    Attributes:
        stamp_ns: of the left image [ns].
        left: shape (h, w), grey, rectified.
        answer: the place and the displacement, or why there is none.
        tilt: roll and pitch of the base that were taken for known [rad].
        rig: the cameras.
        lacks_tilt: whether the base was taken for level though there is an imu, which told nothing near the images.
    """

    stamp_ns: int
    left: NDArray[np.uint8]
    answer: LandmarkFix | NoLandmarkFix
    tilt: tuple[float, float]
    rig: StereoRig
    lacks_tilt: bool = False


class PairLocalizer:
    """Finds the robot by its taught places.

    Args:
        places: all of them.
        rig: the rectified cameras.
        settings: of the method.
        raw: calibrations of the left and the right camera if their images come raw, None if they come rectified.

    Raises:
        StereoLandmarkError: there is no place, or one was taught with other cameras.
    """

    def __init__(
        self,
        places: Sequence[TaughtPlace],
        rig: StereoRig,
        settings: LandmarkSettings,
        raw: tuple[CameraCalibration, CameraCalibration] | None = None,
    ) -> None:
        for place in places:
            check_cameras(place, rig)
        self._rig = rig
        self._localizer = LandmarkLocalizer(places, settings)
        self._rectifiers = None if raw is None else (Rectifier(raw[0]), Rectifier(raw[1]))
        self._latest: tuple[int, str] | None = None
        self._faultless: int | None = None  # the last stamp at which the cameras were known to be a pair [ns]

    def forget(self) -> None:
        """Drop the place where the robot was last."""
        self._latest = None

    def locate(
        self,
        stamp_ns: int,
        left: NDArray[np.uint8],
        right: NDArray[np.uint8],
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> LocatedPair:
        """Find the place and the displacement from it.

        Args:
            stamp_ns: when both images were taken [ns].
            left: shape (h, w), grey.
            right: the same of the right camera.
            tilt: roll and pitch of the base [rad].

        Raises:
            StereoLandmarkError: an image is of a wrong size, or the two are no rectified pair.
        """
        if self._rectifiers is not None:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        answer = self._localizer.locate(left, right, tilt, self._likely(stamp_ns))
        if isinstance(answer, LandmarkFix):
            self._latest = stamp_ns, answer.place.name
            self._faultless = stamp_ns
        else:
            self._check(stamp_ns, left, right)
        return LocatedPair(stamp_ns, left, answer, tilt, self._rig)

    def _check(self, stamp_ns: int, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> None:
        """Raise what is wrong with the cameras; a lost robot, which has most to do, is not asked with each pair."""
        if self._faultless is not None and abs(stamp_ns - self._faultless) <= CHECK_INTERVAL * 1e9:
            return
        fault = pair_fault(left, right, self._rig)
        if fault is not None:
            raise StereoLandmarkError(fault.value)
        self._faultless = stamp_ns

    def _likely(self, stamp_ns: int) -> tuple[str, ...]:
        if self._latest is None or abs(stamp_ns - self._latest[0]) > REMEMBERED * 1e9:
            return ()
        return (self._latest[1],)
