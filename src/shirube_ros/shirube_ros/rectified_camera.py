"""Conversion of the CameraInfo of rectified images: rectified camera and projection matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo

from shirube_core.geometry import PinholeCamera
from shirube_ros.camera_info_conversion import camera_from_camera_info
from shirube_ros.message_error import CameraInfoError


@dataclass(frozen=True, eq=False)
class RigCamera:
    """A rectified camera of a stereo or trinocular rig.

    Attributes:
        camera: intrinsics of the rectified image.
        projection: projection matrix P, shape (3, 4); contains the position of the camera in the rig.
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
    """Return the projection matrix P, shape (3, 4).

    Raises:
        CameraInfoError: P is all zeros.
    """
    projection = np.array(message.p, dtype=np.float64).reshape(3, 4)
    if not projection.any():
        raise CameraInfoError(f'{topic} is not rectified, P is zero; calibrate the cameras as a rig')
    return projection


def rectified_camera(message: CameraInfo, topic: str) -> PinholeCamera:
    """Return the camera of the rectified image, from P, or from K if P is zero and there is no distortion.

    Args:
        message: calibration.
        topic: name for error messages.

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
