"""Reads camera calibrations written by ``camera_calibration`` (YAML)."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from shirube_core.files import YamlFileError, format_value, is_number, read_yaml
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera_info_conversion import camera_from_camera_info
from shirube_ros.file_errors import CalibrationError
from shirube_ros.message_error import CameraInfoError

_REMEDY = 'give the YAML that camera_calibration writes'


def load_calibration(path: Path) -> PinholeCamera:
    """Load the intrinsics of the raw image.

    Raises:
        CalibrationError: the file is missing, not valid YAML, lacks a field or has invalid numbers.
    """
    try:
        content = read_yaml(path)
    except YamlFileError as fault:
        raise CalibrationError(f'{fault}; {_REMEDY}') from fault
    model = content.get('distortion_model', '')
    camera_info = SimpleNamespace(
        width=_size(path, content, 'image_width'),
        height=_size(path, content, 'image_height'),
        k=_numbers(path, content, 'camera_matrix'),
        d=_numbers(path, content, 'distortion_coefficients'),
        distortion_model=model,
    )
    if len(camera_info.k) != 9:
        raise CalibrationError(
            f'{path}: camera_matrix has {len(camera_info.k)} numbers instead of 9; {_REMEDY}'
        )
    try:
        return camera_from_camera_info(camera_info, str(path))
    except CameraInfoError as fault:
        raise CalibrationError(str(fault)) from fault


def _size(path: Path, content: dict[str, Any], field: str) -> int:
    value = content.get(field)
    if isinstance(value, bool) or not isinstance(value, int):
        raise CalibrationError(
            f'{path}: {field} is {format_value(value)}, expected a number of pixels; {_REMEDY}'
        )
    return value


def _numbers(path: Path, content: dict[str, Any], field: str) -> list[float]:
    """Return the entries of a matrix in the file."""
    matrix = content.get(field)
    data = matrix.get('data') if isinstance(matrix, dict) else None
    if not isinstance(data, list):
        raise CalibrationError(f'{path}: {field} with its data is missing; {_REMEDY}')
    if not all(is_number(each) for each in data):
        raise CalibrationError(f'{path}: {field} has values that are not finite numbers; {_REMEDY}')
    return [float(each) for each in data]
