"""Conversion of CameraInfo to camera models: of the raw image (K, D) and of the rectified one (P)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from shirube_core.geometry import PinholeCamera
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
    """Return the intrinsics of the raw image (K and D), with the distortion model ``plumb_bob`` or none.

    Raises:
        CameraInfoError: an uncalibrated camera (zeros), invalid numbers or an unsupported distortion model.
    """
    if message.distortion_model not in ('', 'plumb_bob') or len(message.d) not in (0, 4, 5):
        raise CameraInfoError(
            f'{topic} has the distortion model {message.distortion_model!r} with {len(message.d)} numbers;'
            ' calibrate with plumb_bob (5 numbers)'
        )
    if not any(message.k):
        raise CameraInfoError(f'{topic} is not calibrated, K is zero; {_REMEDY}')
    distortion = [*message.d, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
    fx, _, cx, _, fy, cy = (float(number) for number in message.k[:6])
    k1, k2, p1, p2, k3 = (float(number) for number in distortion)
    try:
        return PinholeCamera(message.width, message.height, fx, fy, cx, cy, (k1, k2, p1, p2, k3))
    except ValueError as error:
        raise CameraInfoError(f'{topic}: {error}; {_REMEDY}') from error


def check_image_size(camera: SizedCamera, shape: tuple[int, ...], topic: str, info_topic: str) -> None:
    """Raise a CameraInfoError if the shape of an image, (h, w) or (h, w, 3), differs from its calibration's
    size.
    """
    height, width = shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise CameraInfoError(
            f'{topic} is {width} x {height} px but {info_topic} is for {camera.width} x {camera.height} px;'
            ' calibrate at the resolution (and binning) in use'
        )


@dataclass(frozen=True, eq=False)
class RigCamera:
    """Intrinsics of the rectified camera of a rig, and its projection matrix P, shape (3, 4), with its
    position.
    """

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
    """Return the projection matrix P, shape (3, 4); raise a CameraInfoError if it is zero."""
    projection = np.array(message.p, dtype=np.float64).reshape(3, 4)
    if not projection.any():
        raise CameraInfoError(f'{topic} is not rectified, P is zero; calibrate the cameras as a rig')
    return projection


def rectified_camera(message: CameraInfo, topic: str) -> PinholeCamera:
    """Return the camera of the rectified image, from P, or from K if P is zero and there is no distortion.

    Raises:
        CameraInfoError: zeros, invalid numbers, or distortion without P.
    """
    if not any(message.p):
        camera = camera_from_camera_info(message, topic)
        if any(camera.distortion):
            raise CameraInfoError(f'{topic} has distortion and no P; publish rectified images with P')
        return camera
    fx, _, cx, _, _, fy, cy = (float(number) for number in message.p[:7])
    try:
        return PinholeCamera(message.width, message.height, fx, fy, cx, cy)
    except ValueError as error:
        raise CameraInfoError(f'{topic}: {error}; calibrate the camera') from error
