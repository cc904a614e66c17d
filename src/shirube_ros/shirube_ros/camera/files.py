"""Camera calibrations (YAML of ``camera_calibration``) and images on disk."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from shirube_core.files import YamlFileError, format_value, is_number, read_yaml
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.image import decode_file, is_truncated
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.errors import CalibrationError, CameraInfoError, ImageFileError

_REMEDY = 'give the YAML that camera_calibration writes'


def load_calibration(path: Path) -> PinholeCamera:
    """Load the intrinsics of the raw image; raise a CalibrationError if the file or its numbers are invalid."""
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
        raise CalibrationError(f'{path}: camera_matrix has {len(camera_info.k)} numbers instead of 9; {_REMEDY}')
    try:
        return camera_from_camera_info(camera_info, str(path))
    except CameraInfoError as fault:
        raise CalibrationError(str(fault)) from fault


def load_camera_info(path: Path) -> CameraInfo:
    """Load a calibration with R and P, if it has them; raise a CalibrationError if the file is invalid."""
    camera, content = load_calibration(path), read_yaml(path)
    info = CameraInfo(width=camera.width, height=camera.height, distortion_model=camera.model.value)
    info.d, info.k = list(camera.distortion), camera.matrix.ravel()
    for name, field, count in (('r', 'rectification_matrix', 9), ('p', 'projection_matrix', 12)):
        if field in content:
            numbers = _numbers(path, content, field)
            if len(numbers) != count:
                raise CalibrationError(f'{path}: {field} has {len(numbers)} numbers instead of {count}; {_REMEDY}')
            setattr(info, name, numbers)
    return info


def calibration_text(
    name: str, camera: PinholeCamera, rotation: NDArray[np.float64], projection: NDArray[np.float64]
) -> str:
    """Return the text of the file that camera_calibration writes.

    Args:
        name: name of the camera.
        camera: intrinsics of the raw image.
        rotation: R from the raw optical frame to the rectified one, shape (3, 3).
        projection: P of the rectified image, shape (3, 4).
    """
    content = {
        'image_width': camera.width,
        'image_height': camera.height,
        'camera_name': name,
        'camera_matrix': _matrix(camera.matrix),
        'distortion_model': camera.model.value,
        'distortion_coefficients': _matrix(np.array([camera.distortion])),
        'rectification_matrix': _matrix(rotation),
        'projection_matrix': _matrix(projection),
    }
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None)


def _matrix(values: NDArray[np.float64]) -> dict[str, object]:
    return {'rows': values.shape[0], 'cols': values.shape[1], 'data': np.round(values, 12).ravel().tolist()}


def _size(path: Path, content: dict[str, Any], field: str) -> int:
    value = content.get(field)
    if isinstance(value, bool) or not isinstance(value, int):
        raise CalibrationError(f'{path}: {field} is {format_value(value)}, expected a number of pixels; {_REMEDY}')
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


_SUFFIXES = frozenset({'.bmp', '.jpeg', '.jpg', '.pgm', '.png', '.ppm', '.tif', '.tiff', '.webp'})


def list_images(paths: Sequence[Path]) -> list[Path]:
    """Return the files, and for a folder its images by name; raise an ImageFileError if there are none."""
    images: list[Path] = []
    for path in paths:
        if not path.exists():
            raise ImageFileError(f'{path}: does not exist; give images or a folder of images')
        if path.is_dir():
            found = sorted(each for each in path.iterdir() if each.suffix.lower() in _SUFFIXES)
            if not found:
                raise ImageFileError(f'{path}: has no images in it; give a folder of PNG or JPEG files')
            images += found
        else:
            images.append(path)
    return images


def load_image(path: Path) -> NDArray[np.uint8]:
    """Load one image, shape (h, w) for grey or (h, w, 3) in order blue, green, red; 16 bits become 8.

    Raises:
        ImageFileError: the file is not an image, or is truncated.
    """
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as fault:
        raise ImageFileError(f'{path}: cannot be read ({fault.strerror}); give an image') from fault
    if is_truncated(data):
        raise ImageFileError(f'{path}: is truncated; copy or record it again')
    pixels = decode_file(data)
    if pixels is None:
        raise ImageFileError(f'{path}: is no image, or corrupted; give a PNG or JPEG file')
    return pixels
