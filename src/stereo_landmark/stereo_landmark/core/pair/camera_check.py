"""Check that a place was taught with the present cameras."""

from __future__ import annotations

import hashlib

import numpy as np

from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

INTRINSICS = ('width', 'height', 'fx', 'fy', 'cx', 'cy')
"""Intrinsics of a rectified camera that enter the calibration hash."""
_MOUNT_TOLERANCE = 1e-6
"""Tolerance of the mount's position [m] and rotation [rad]."""


def calibration_hash(rig: StereoRig) -> str:
    """Return a hash of the rectified intrinsics and the baseline, rounded to nine digits."""
    numbers = [getattr(camera, name) for camera in (rig.left, rig.right) for name in INTRINSICS]
    text = ' '.join(f'{number:.9g}' for number in (*numbers, rig.baseline))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


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
