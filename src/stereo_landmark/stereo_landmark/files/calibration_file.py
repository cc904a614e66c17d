"""Loads the calibration of one camera of a stereo pair from the YAML that ``camera_calibration`` writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from shirube_ros.camera.files import load_calibration
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.yaml_file import LandmarkFileError, read_yaml

_REMEDY = 'give the YAML that camera_calibration writes for a camera of a stereo pair'


def load_camera_calibration(path: Path) -> CameraCalibration:
    """Load the calibration of one camera.

    Raises:
        CalibrationError: the file is missing, not YAML, or without intrinsics.
        LandmarkFileError: the rectification or projection matrix is missing or malformed.
    """
    raw = load_calibration(path)
    content = read_yaml(path, _REMEDY)
    rotation = _numbers(path, content, 'rectification_matrix')
    projection = _numbers(path, content, 'projection_matrix')
    try:
        return CameraCalibration(raw, rotation, projection)
    except StereoLandmarkError as fault:
        raise LandmarkFileError(f'{path}: {fault}') from fault


def _numbers(path: Path, content: dict[str, Any], field: str) -> tuple[float, ...]:
    matrix = content.get(field)
    data = matrix.get('data') if isinstance(matrix, dict) else None
    if not isinstance(data, list) or not all(isinstance(each, int | float) for each in data):
        raise LandmarkFileError(f'{path}: {field} with its data is missing; {_REMEDY}')
    return tuple(float(number) for number in data)
