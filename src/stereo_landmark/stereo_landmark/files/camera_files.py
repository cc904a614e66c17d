"""Grey images and camera calibrations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_ros.camera.files import load_calibration, load_image
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.yaml_file import LandmarkFileError, read_yaml


def load_grey_image(path: Path) -> NDArray[np.uint8]:
    """Load an image as grey, shape (h, w).

    Raises:
        ImageFileError: the file is not an image, is truncated, or has more than 8 bits per channel.
    """
    return to_grey(load_image(path))


def to_grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert an image to grey, shape (h, w).

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3).
    """
    if pixels.ndim == 2:
        return pixels
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def encode_png(image: NDArray[np.uint8]) -> bytes:
    """Encode a grey image, shape (h, w), as PNG."""
    _, data = cv2.imencode('.png', image)
    return data.tobytes()


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
