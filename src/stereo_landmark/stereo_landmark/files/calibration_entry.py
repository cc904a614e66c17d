"""Converts the stereo calibration of a taught place to and from its file entry (paper 3.3a)."""

from __future__ import annotations

import dataclasses
from typing import Any

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.pair.camera_check import INTRINSICS, calibration_hash
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_REMEDY = 'restore the file or teach the place again'


def calibration_entry(rig: StereoRig) -> dict[str, Any]:
    """Return the file entry of the stereo calibration."""
    left, right = (
        {name: value for name, value in dataclasses.asdict(camera).items() if name in INTRINSICS}
        for camera in (rig.left, rig.right)
    )
    return {
        'hash': calibration_hash(rig),
        'left': left,
        'right': right,
        'baseline': rig.baseline,
        'camera_xyz': rig.mount.xyz,
        'camera_rpy': rig.mount.rpy,
    }


def rig_from_entry(entry: dict[str, Any]) -> StereoRig:
    """Return the stereo calibration of an entry that passed the schema check.

    Raises:
        StereoLandmarkError: the cameras are not a stereo pair, or do not match the hash.
    """
    left, right = (_camera(entry[side]) for side in ('left', 'right'))
    mount = CameraMount(_to_triple(entry['camera_xyz']), _to_triple(entry['camera_rpy']))
    try:
        rig = StereoRig(left, right, float(entry['baseline']), mount)
    except StereoLandmarkError as fault:
        raise StereoLandmarkError(f'stereo_calibration: {fault}') from fault
    if calibration_hash(rig) != entry['hash']:
        raise StereoLandmarkError(f'stereo_calibration: hash does not match the calibration; {_REMEDY}')
    return rig


def _camera(entry: dict[str, Any]) -> PinholeCamera:
    fx, fy, cx, cy = (float(entry[name]) for name in INTRINSICS[2:])
    return PinholeCamera(entry['width'], entry['height'], fx, fy, cx, cy)


def _to_triple(values: list[float]) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z
