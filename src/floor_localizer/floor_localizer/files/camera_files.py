"""Writes a camera's mount as a parameter file, and its intrinsics in the format of camera_calibration."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import yaml

from shirube_core.files import write_text
from shirube_core.geometry import CameraMount, PinholeCamera


def save_mount(path: Path, mount: CameraMount, notes: Sequence[str]) -> None:
    """Write ``camera_xyz`` and ``camera_rpy`` as a parameter file of the node, atomically.

    Args:
        path: the file.
        mount: pose of the camera in the base frame.
        notes: comment lines at the top of the file.

    Raises:
        OSError: the file cannot be written.
    """
    parameters = {
        'camera_xyz': [round(value, 6) for value in mount.xyz],
        'camera_rpy': [round(value, 6) for value in mount.rpy],
    }
    content = {'floor_localizer': {'ros__parameters': parameters}}
    head = ''.join(f'# {note}\n' for note in notes)
    write_text(path, head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None))


def save_intrinsics(path: Path, camera: PinholeCamera) -> None:
    """Write the intrinsics, atomically.

    Raises:
        OSError: the file cannot be written.
    """
    content = {
        'image_width': camera.width,
        'image_height': camera.height,
        'camera_name': 'belly_camera',
        'camera_matrix': {'rows': 3, 'cols': 3, 'data': camera.matrix.ravel().tolist()},
        'distortion_model': 'plumb_bob',
        'distortion_coefficients': {'rows': 1, 'cols': 5, 'data': list(camera.distortion)},
    }
    write_text(path, yaml.safe_dump(content, sort_keys=False, default_flow_style=None))
