"""Pairs of images, one after another, to where the robot is: what a node and a recorded drive have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import TiltTrail
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


@dataclass(frozen=True)
class LocatedPair:
    """What a pair of images told.

    Attributes:
        left: shape (h, w), grey, rectified.
        answer: the place and the displacement, or why there is none.
        tilt: roll and pitch of the base that were taken for known [rad].
        rig: the cameras.
    """

    left: NDArray[np.uint8]
    answer: LandmarkFix | NoLandmarkFix
    tilt: tuple[float, float]
    rig: StereoRig


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
        self._tilt = TiltTrail()
        self._latest: tuple[float, str] | None = None

    def add_tilt(self, stamp: float, roll: float, pitch: float) -> None:
        """Take fixed-axis roll and pitch of the base at a time [rad, s]."""
        self._tilt.add(stamp, roll, pitch)

    def forget(self) -> None:
        """Drop the place where the robot was last."""
        self._latest = None

    def locate(self, stamp: float, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> LocatedPair:
        """Find the place and the displacement from it.

        Args:
            stamp: when both images were taken [s].
            left: shape (h, w), grey.
            right: the same of the right camera.

        Raises:
            StereoLandmarkError: an image is of a wrong size, or the two are no rectified pair.
        """
        if self._rectifiers is not None:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        tilt = self._tilt.tilt_at(stamp) or (0.0, 0.0)
        answer = self._localizer.locate(left, right, tilt, self._likely(stamp))
        if isinstance(answer, LandmarkFix):
            self._latest = stamp, answer.place.name
        elif (fault := pair_fault(left, right, self._rig)) is not None:
            raise StereoLandmarkError(fault.value)
        return LocatedPair(left, answer, tilt, self._rig)

    def _likely(self, stamp: float) -> tuple[str, ...]:
        if self._latest is None or abs(stamp - self._latest[0]) > REMEMBERED:
            return ()
        return (self._latest[1],)
