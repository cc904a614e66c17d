"""Synchronizes left and right images and localizes the pairs; shared by the node and bag localization."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import CameraMount, TiltBuffer
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.pair.pair_localizer import LocatedPair, PairLocalizer
from stereo_landmark.core.pair.stamp_synchronizer import StampSynchronizer
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings, PairSettings


class Side(IntEnum):
    """Camera of the stereo pair."""

    LEFT = 0
    RIGHT = 1


@dataclass(frozen=True)
class _QueuedImage:
    """An image in the queue of the synchronizer."""

    stamp_ns: int
    pixels: NDArray[np.uint8]
    calibration: CameraCalibration


class PairStream:
    """Synchronizes stereo images and localizes the pairs.

    Args:
        places: all taught places.
        mount: pose of the rectified left optical frame in the base frame.
        pairing: synchronization settings, and whether to rectify.
        settings: settings of the search and the pose fit.
    """

    def __init__(
        self,
        places: Sequence[TaughtPlace],
        mount: CameraMount,
        pairing: PairSettings,
        settings: LandmarkSettings,
    ) -> None:
        self._places = places
        self._mount = mount
        self._pairing = pairing
        self._settings = settings
        self._synchronizer: StampSynchronizer[_QueuedImage] = StampSynchronizer(
            pairing.tolerance_ns, pairing.queue_size
        )
        self._tilt = TiltBuffer()
        self._has_imu = False
        self._calibrations: tuple[CameraCalibration, CameraCalibration] | None = None
        self._localizer: PairLocalizer | None = None

    def add_tilt(self, stamp: float, roll: float, pitch: float) -> None:
        """Add an IMU reading.

        Args:
            stamp: time of the reading [s].
            roll: fixed-axis roll of the base [rad].
            pitch: fixed-axis pitch of the base [rad].
        """
        self._tilt.add(stamp, roll, pitch)
        self._has_imu = True

    def add_image(
        self, side: Side, stamp_ns: int, pixels: NDArray[np.uint8], calibration: CameraCalibration
    ) -> LocatedPair | None:
        """Add an image; return the result of the pair that it completes, None if it completes none.

        Args:
            side: camera of the image.
            stamp_ns: stamp of the image [ns].
            pixels: grey image, shape (h, w).
            calibration: calibration of the camera.

        Raises:
            StereoLandmarkError: the stamps do not match, the calibrations are not a stereo pair or not the cameras of
                the places, or the images are not a rectified pair.
        """
        pair = self._synchronizer.add(side, stamp_ns, _QueuedImage(stamp_ns, pixels, calibration))
        if pair is None:
            return None
        left, right = pair
        localizer = self.get_localizer(left.calibration, right.calibration)
        tilt = self._tilt.tilt_at(left.stamp_ns * 1e-9)
        located = localizer.locate(left.stamp_ns, left.pixels, right.pixels, tilt or (0.0, 0.0))
        return replace(located, is_tilt_missing=self._has_imu and tilt is None)

    def drop_prior(self) -> None:
        """Drop the prior: search all places in the next pair."""
        if self._localizer is not None:
            self._localizer.drop_prior()

    def get_localizer(self, left: CameraCalibration, right: CameraCalibration) -> PairLocalizer:
        """Return the localizer for these calibrations; it is created again when they change.

        Raises:
            StereoLandmarkError: the calibrations are not a stereo pair, or not the cameras of the places.
        """
        if self._localizer is None or self._calibrations != (left, right):
            rig = stereo_rig(left, right, self._mount)
            raw = (left, right) if self._pairing.rectify else None
            self._localizer = PairLocalizer(self._places, rig, self._settings, raw)
            self._calibrations = left, right
        return self._localizer
