"""Synchronizes left and right images and localizes the pairs; shared by the node and bag localization."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shirube_core.geometry import CameraMount, TiltBuffer
from stereo_landmark.core.arrays import GreyImage
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix, PlacePrior
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, Side, StampSynchronizer, stereo_rig
from stereo_landmark.core.pair.rectification_check import check_pair
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings, PairSettings
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.view_localizer import state_of

LAST_PLACE_TIMEOUT = 10.0
"""How long the last place is searched first [s]."""
PREDICTION_MAX = 0.5
"""Longest time between fixes over which a pose is predicted [s]."""

CHECK_INTERVAL = 2.0
"""Time between two epipolar checks of the cameras [s]."""
_RELATIVE_CHANGE_MAX = 0.05
"""Largest relative change of baseline and focal length by a calibration."""
_MOUNT_CHANGE_MAX = 0.02
"""Largest change of the mount's position [m] and rotation [rad] by a calibration."""


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
    left: GreyImage
    result: LandmarkFix | NoLandmarkFix
    tilt: tuple[float, float]
    rig: StereoRig
    is_tilt_missing: bool = False


class PairLocalizer:
    """Localizes pairs of the same cameras; remembers the last place.

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
        self._rig = rig
        self._localizer = LandmarkLocalizer([recalibrate(place, rig) for place in places], settings)
        self._rectifiers = None if raw is None else (Rectifier(raw[0]), Rectifier(raw[1]))
        self.last_fixes: list[tuple[int, LandmarkFix]] = []  # the last two, with their stamps [ns]
        self._last_valid_stamp: int | None = None  # last stamp with a valid rectified pair [ns]

    def apply_settings(self, settings: LandmarkSettings) -> None:
        """Use other settings from the next pair on; the last place is kept."""
        self._localizer = LandmarkLocalizer(self._localizer.places, settings)

    def locate(self, stamp_ns: int, left: GreyImage, right: GreyImage, tilt: tuple[float, float]) -> LocatedPair:
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
        result = self._localizer.locate(left, right, tilt, self._predict(stamp_ns))
        if isinstance(result, LandmarkFix):
            self.last_fixes = [*self.last_fixes[-1:], (stamp_ns, result)]
            self._last_valid_stamp = stamp_ns
        elif self._last_valid_stamp is None or abs(stamp_ns - self._last_valid_stamp) > CHECK_INTERVAL * 1e9:
            # The check is slow, so a lost robot checks its cameras now and then only.
            check = check_pair(left, right, self._rig)
            if check.fault is not None:
                raise StereoLandmarkError(check.summary)
            self._last_valid_stamp = stamp_ns
        return LocatedPair(stamp_ns, left, result, tilt, self._rig)

    def _predict(self, stamp_ns: int) -> PlacePrior | None:
        """Return the last place, and the pose there at constant velocity since the last two fixes."""
        if not self.last_fixes or abs(stamp_ns - self.last_fixes[-1][0]) > LAST_PLACE_TIMEOUT * 1e9:
            return None
        (before, first), (last, second) = self.last_fixes[0], self.last_fixes[-1]
        name, passed = second.place.name, stamp_ns - last
        if first.place.name != name or not 0 < passed <= PREDICTION_MAX * 1e9:
            return PlacePrior(name)
        state = state_of(second.displacement)
        if 0 < last - before <= PREDICTION_MAX * 1e9:
            state = state + (state - state_of(first.displacement)) * (passed / (last - before))
        return PlacePrior(name, state)


def recalibrate(place: TaughtPlace, rig: StereoRig) -> TaughtPlace:
    """Return a place for the present calibration of its cameras; its points stay where they are in space.

    Raises:
        StereoLandmarkError: image size, baseline, focal length or mount differ by more than a calibration changes them.
    """
    taught = place.rig
    size, now = ((each.left.width, each.left.height) for each in (taught, rig))
    changes = (
        ('image size', f'{size[0]}x{size[1]}', f'{now[0]}x{now[1]}', size != now),
        ('baseline', f'{taught.baseline:.4g} m', f'{rig.baseline:.4g} m', _ratio(taught.baseline, rig.baseline)),
        ('fx', f'{taught.left.fx:.4g} px', f'{rig.left.fx:.4g} px', _ratio(taught.left.fx, rig.left.fx)),
        *(
            (f'camera_{name}', _format_vector(old), _format_vector(new), _distance(old, new))
            for name, old, new in (('xyz', taught.mount.xyz, rig.mount.xyz), ('rpy', taught.mount.rpy, rig.mount.rpy))
        ),
    )
    for name, old, new, is_other in changes:
        if is_other:
            raise StereoLandmarkError(
                f'place {place.name} was taught with {name} {old}, now it is {new}; '
                'use the cameras it was taught with, or teach it again'
            )
    return replace(place, rig=rig)


def _ratio(taught: float, present: float) -> bool:
    return abs(present / taught - 1.0) > _RELATIVE_CHANGE_MAX


def _distance(taught: tuple[float, ...], present: tuple[float, ...]) -> bool:
    return not np.allclose(taught, present, rtol=0.0, atol=_MOUNT_CHANGE_MAX)


def _format_vector(numbers: tuple[float, ...]) -> str:
    return '[' + ', '.join(f'{number:.6g}' for number in numbers) + ']'


_QueuedImage = tuple[int, GreyImage, CameraCalibration]
"""Stamp [ns], pixels and calibration of an image in the queue of the synchronizer."""


class PairStream:
    """Synchronizes stereo images and localizes the pairs.

    Args:
        places: all taught places.
        mount: pose of the rectified left optical frame in the base frame.
        pairing: synchronization settings, and whether to rectify.
        settings: settings of the search and the pose fit.
    """

    def __init__(
        self, places: Sequence[TaughtPlace], mount: CameraMount, pairing: PairSettings, settings: LandmarkSettings
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

    def apply_settings(self, settings: LandmarkSettings) -> None:
        """Use other settings from the next pair on."""
        self._settings = settings
        if self._localizer is not None:
            self._localizer.apply_settings(settings)

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
        self, side: Side, stamp_ns: int, pixels: GreyImage, calibration: CameraCalibration
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
        pair = self._synchronizer.add(side, stamp_ns, (stamp_ns, pixels, calibration))
        if pair is None:
            return None
        (stamp_ns, left, left_calibration), (_, right, right_calibration) = pair
        localizer = self.get_localizer(left_calibration, right_calibration)
        tilt = self._tilt.tilt_at(stamp_ns * 1e-9)
        located = localizer.locate(stamp_ns, left, right, tilt or (0.0, 0.0))
        return replace(located, is_tilt_missing=self._has_imu and tilt is None)

    def drop_prior(self) -> None:
        """Drop the prior: search all places in the next pair."""
        if self._localizer is not None:
            self._localizer.last_fixes = []

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
