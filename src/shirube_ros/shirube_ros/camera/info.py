"""Conversion of CameraInfo to camera models: of the raw image (K, D) and of the rectified one (P)."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from shirube_core.geometry import LensModel, PinholeCamera
from shirube_ros.errors import CameraInfoError

_REMEDY = 'calibrate the camera (camera_calibration) and load the file in its driver'


class SizedCamera(Protocol):
    """A camera model with an image size."""

    @property
    def width(self) -> int:
        """Image width [px]."""

    @property
    def height(self) -> int:
        """Image height [px]."""


def camera_from_camera_info(message: CameraInfo, topic: str) -> PinholeCamera:
    """Return the intrinsics of the raw image (K and D), for its region of interest and binning.

    Raises:
        CameraInfoError: an uncalibrated camera (zeros), invalid numbers, an unknown distortion model or a wrong number
            of its coefficients.
    """
    if not any(message.k):
        raise CameraInfoError(f'{topic} is not calibrated, K is zero; {_REMEDY}')
    model, distortion = _lens_model(message, topic)
    window = sensor_window(message, topic)
    (fx, _, cx), (_, fy, cy), _ = window.matrix @ np.array(message.k, dtype=np.float64).reshape(3, 3)
    try:
        return PinholeCamera(window.width, window.height, float(fx), float(fy), float(cx), float(cy), distortion, model)
    except ValueError as error:
        raise CameraInfoError(f'{topic}: {error}; {_REMEDY}') from error


def _lens_model(message: CameraInfo, topic: str) -> tuple[LensModel, tuple[float, ...]]:
    """Return the model and its coefficients; zeros beyond the most that it has are dropped."""
    name, distortion = message.distortion_model or LensModel.PLUMB_BOB.value, [float(d) for d in message.d]
    known = {model.value: model for model in LensModel}
    if name not in known:
        raise CameraInfoError(
            f'{topic} has the unknown distortion model {name!r}; calibrate with one of {", ".join(known)}'
        )
    counts = known[name].counts
    while len(distortion) > counts[-1] and distortion[-1] == 0.0:
        distortion.pop()
    if len(distortion) not in counts:
        raise CameraInfoError(
            f'{topic} has the distortion model {name!r} with {len(distortion)} numbers instead of '
            f'{" or ".join(map(str, counts))}; {_REMEDY}'
        )
    if known[name] is LensModel.PLUMB_BOB:
        distortion = [*distortion, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
    return known[name], tuple(distortion)


@dataclass(frozen=True, eq=False)
class SensorWindow:
    """The image as a part of the sensor: region of interest and binning.

    Attributes:
        width: width of the image [px].
        height: height of the image [px].
        matrix: transformation of homogeneous pixels of the calibration's full image to the image, shape (3, 3).
    """

    width: int
    height: int
    matrix: NDArray[np.float64]


def sensor_window(message: CameraInfo, topic: str) -> SensorWindow:
    """Return the part of the sensor that a CameraInfo's image is of.

    As in image_geometry, K and P are those of the full image; the region is in its pixels, before binning, also of the
    rectified image. Unlike there, the middle of n x n pixels stays in the middle: not u / n, but (u + 1/2) / n - 1/2.

    Raises:
        CameraInfoError: the region is not in the image.
    """
    region = getattr(message, 'roi', None)  # a calibration file has none
    x, y, width, height = (
        (0, 0, 0, 0) if region is None else (region.x_offset, region.y_offset, region.width, region.height)
    )
    width, height = width or message.width - x, height or message.height - y
    if x + width > message.width or y + height > message.height:
        raise CameraInfoError(
            f'{topic} has the region of interest {width} x {height} px at ({x}, {y}) in an image of '
            f'{message.width} x {message.height} px; correct roi in the camera driver'
        )
    bin_x, bin_y = (max(getattr(message, name, 1), 1) for name in ('binning_x', 'binning_y'))
    matrix = np.array(
        [[1.0 / bin_x, 0.0, (0.5 - x) / bin_x - 0.5], [0.0, 1.0 / bin_y, (0.5 - y) / bin_y - 0.5], [0.0, 0.0, 1.0]]
    )
    return SensorWindow(width // bin_x, height // bin_y, matrix)


def check_image_size(camera: SizedCamera, shape: tuple[int, ...], topic: str, info_topic: str) -> None:
    """Raise a CameraInfoError if an image, shape (h, w) or (h, w, 3), has another size than its calibration."""
    height, width = shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise CameraInfoError(
            f'{topic} is {width} x {height} px but {info_topic} is for {camera.width} x {camera.height} px;'
            ' calibrate at the resolution (and binning) in use'
        )


@dataclass(frozen=True, eq=False)
class RigCamera:
    """Intrinsics of a rig's rectified camera, and its projection P, shape (3, 4), with its position."""

    camera: PinholeCamera
    projection: NDArray[np.float64]

    @property
    def width(self) -> int:
        """Image width [px]."""
        return self.camera.width

    @property
    def height(self) -> int:
        """Image height [px]."""
        return self.camera.height


def rig_camera(message: CameraInfo, topic: str) -> RigCamera:
    """Return a camera of a rig; arguments and errors as in the two functions below."""
    return RigCamera(rectified_camera(message, topic), projection_from_camera_info(message, topic))


def projection_from_camera_info(message: CameraInfo, topic: str) -> NDArray[np.float64]:
    """Return the projection matrix P, shape (3, 4), for the image's region of interest and binning.

    Raises:
        CameraInfoError: P is zero, or the region is not in the image.
    """
    projection = np.array(message.p, dtype=np.float64).reshape(3, 4)
    if not projection.any():
        raise CameraInfoError(f'{topic} is not rectified, P is zero; calibrate the cameras as a rig')
    return np.asarray(sensor_window(message, topic).matrix @ projection)


def rectified_camera(message: CameraInfo, topic: str) -> PinholeCamera:
    """Return the camera of the rectified image, from P, or from K if P is zero and there is no distortion.

    Raises:
        CameraInfoError: zeros, invalid numbers, or distortion without P.
    """
    if not any(message.p):
        camera = camera_from_camera_info(message, topic)
        if camera.has_distortion:
            raise CameraInfoError(f'{topic} has distortion and no P; publish rectified images with P')
        return camera
    window = sensor_window(message, topic)
    (fx, _, cx, _), (_, fy, cy, _), _ = projection_from_camera_info(message, topic)
    try:
        return PinholeCamera(window.width, window.height, float(fx), float(fy), float(cx), float(cy))
    except ValueError as error:
        raise CameraInfoError(f'{topic}: {error}; calibrate the camera') from error
