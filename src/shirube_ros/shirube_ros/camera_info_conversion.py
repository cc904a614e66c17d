"""Conversion of CameraInfo to the camera model of shirube_core.geometry."""

from __future__ import annotations

from typing import Protocol

from sensor_msgs.msg import CameraInfo

from shirube_core.geometry import PinholeCamera
from shirube_ros.message_error import CameraInfoError

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
    """Return the intrinsics of the raw image (K and D).

    Args:
        message: calibration with the distortion model ``plumb_bob`` or none.
        topic: name for error messages.

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
    """Reject an image whose size differs from that of the calibration.

    Args:
        camera: intrinsics from the CameraInfo.
        shape: shape of the image, (h, w) or (h, w, 3).
        topic: topic of the image, for error messages.
        info_topic: topic of the CameraInfo, for error messages.

    Raises:
        CameraInfoError: the sizes differ.
    """
    height, width = shape[:2]
    if (width, height) != (camera.width, camera.height):
        raise CameraInfoError(
            f'{topic} is {width} x {height} px but {info_topic} is for {camera.width} x {camera.height} px;'
            ' calibrate at the resolution (and binning) in use'
        )
