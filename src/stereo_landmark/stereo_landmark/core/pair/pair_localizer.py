"""Localization of consecutive stereo pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, Rectifier
from stereo_landmark.core.pair.epipolar_check import pair_fault
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoRig, calibration_hash
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

LAST_PLACE_TIMEOUT = 10.0
"""How long the last place is searched first [s]."""

CHECK_INTERVAL = 2.0
"""Time between two epipolar checks of the cameras [s]."""
_MOUNT_TOLERANCE = 1e-6
"""Tolerance of the mount's position [m] and rotation [rad]."""


@dataclass(frozen=True)
class LocatedPair:
    """Localization result of a stereo pair.

    Attributes:
        stamp_ns: stamp of the left image [ns].
        left: rectified grey image of the left camera, shape (h, w).
        result: place and displacement, or the reason why there is no fix.
        tilt: assumed roll and pitch of the base [rad].
        rig: rectified cameras.
        is_tilt_missing: whether the base was assumed level because the IMU has no reading near the stamp.
    """

    stamp_ns: int
    left: NDArray[np.uint8]
    result: LandmarkFix | NoLandmarkFix
    tilt: tuple[float, float]
    rig: StereoRig
    is_tilt_missing: bool = False


class PairLocalizer:
    """Localizes the robot relative to its taught places; remembers the last place.

    Args:
        places: all taught places.
        rig: rectified cameras.
        settings: settings of the search and the pose fit.
        raw: calibrations of the left and the right camera for raw input images, None for rectified ones.

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
        self._last_place: tuple[int, str] | None = None
        self._last_valid_stamp: int | None = None  # last stamp with a valid rectified pair [ns]

    def drop_prior(self) -> None:
        """Drop the prior: search all places in the next pair."""
        self._last_place = None

    def locate(
        self,
        stamp_ns: int,
        left: NDArray[np.uint8],
        right: NDArray[np.uint8],
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> LocatedPair:
        """Find the place and the displacement from it.

        Args:
            stamp_ns: stamp of both images [ns].
            left: grey image of the left camera, shape (h, w).
            right: grey image of the right camera, shape (h, w).
            tilt: roll and pitch of the base [rad].

        Raises:
            StereoLandmarkError: an image has a wrong size, or the images are not a rectified pair.
        """
        if self._rectifiers is not None:
            left, right = self._rectifiers[0].rectify(left), self._rectifiers[1].rectify(right)
        result = self._localizer.locate(left, right, tilt, self._likely_places(stamp_ns))
        if isinstance(result, LandmarkFix):
            self._last_place = stamp_ns, result.place.name
            self._last_valid_stamp = stamp_ns
        else:
            self._check_cameras(stamp_ns, left, right)
        return LocatedPair(stamp_ns, left, result, tilt, self._rig)

    def _check_cameras(self, stamp_ns: int, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> None:
        """Raise the fault of the cameras, if any; checked at most once per interval, as the check is slow."""
        if (
            self._last_valid_stamp is not None
            and abs(stamp_ns - self._last_valid_stamp) <= CHECK_INTERVAL * 1e9
        ):
            return
        fault = pair_fault(left, right, self._rig)
        if fault is not None:
            raise StereoLandmarkError(fault.value)
        self._last_valid_stamp = stamp_ns

    def _likely_places(self, stamp_ns: int) -> tuple[str, ...]:
        if self._last_place is None or abs(stamp_ns - self._last_place[0]) > LAST_PLACE_TIMEOUT * 1e9:
            return ()
        return (self._last_place[1],)


def check_cameras(place: TaughtPlace, rig: StereoRig) -> None:
    """Check that the cameras are those with which a place was taught.

    Raises:
        StereoLandmarkError: intrinsics, baseline or camera mount differ.
    """
    taught, present = calibration_hash(place.rig), calibration_hash(rig)
    if taught != present:
        raise StereoLandmarkError(
            f'place {place.name} was taught with other cameras (calibration {taught}, now {present}); '
            'use the calibration it was taught with, or teach it again'
        )
    for name, mine, other in (
        ('camera_xyz', rig.mount.xyz, place.rig.mount.xyz),
        ('camera_rpy', rig.mount.rpy, place.rig.mount.rpy),
    ):
        if not np.allclose(mine, other, rtol=0.0, atol=_MOUNT_TOLERANCE):
            raise StereoLandmarkError(
                f'place {place.name} was taught with {name} {_format_vector(other)}, now it is {_format_vector(mine)}; '
                'set the taught value, or teach the place again'
            )


def _format_vector(numbers: tuple[float, ...]) -> str:
    return '[' + ', '.join(f'{number:.6g}' for number in numbers) + ']'
