"""The cameras of a taught place as an entry of a file (paper 3.3a)."""

from __future__ import annotations

import dataclasses
from typing import Any

from shirube_geometry import CameraMount, PinholeCamera
from stereo_landmark.core.pair.same_cameras import INTRINSICS, calibration_hash
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_REMEDY = 'restore the file or teach the place again'


def calibration_entry(rig: StereoRig) -> dict[str, Any]:
    """Return the cameras by their fields."""
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
    """Return the cameras of an entry that fits the schema.

    Raises:
        StereoLandmarkError: they are no stereo pair, or not those that the hash was made of.
    """
    left, right = (_camera(entry[side]) for side in ('left', 'right'))
    mount = CameraMount(_three(entry['camera_xyz']), _three(entry['camera_rpy']))
    try:
        rig = StereoRig(left, right, float(entry['baseline']), mount)
    except StereoLandmarkError as fault:
        raise StereoLandmarkError(f'stereo_calibration: {fault}') from fault
    if calibration_hash(rig) != entry['hash']:
        raise StereoLandmarkError(f'stereo_calibration: hash is not that of its numbers; {_REMEDY}')
    return rig


def _camera(entry: dict[str, Any]) -> PinholeCamera:
    fx, fy, cx, cy = (float(entry[name]) for name in INTRINSICS[2:])
    return PinholeCamera(entry['width'], entry['height'], fx, fy, cx, cy)


def _three(values: list[float]) -> tuple[float, float, float]:
    x, y, z = map(float, values)
    return x, y, z
