"""Conversion of CameraInfo to the calibration of one camera of a stereo pair."""

from __future__ import annotations

from typing import Any

from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.errors import CameraInfoError
from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def calibration_from_camera_info(message: Any, topic: str) -> CameraCalibration:
    """Return the calibration of the raw and the rectified image.

    Args:
        message: sensor_msgs/CameraInfo of a camera of a stereo pair.
        topic: topic name for error messages.

    Raises:
        CameraInfoError: the camera is not calibrated, or not as part of a stereo pair.
    """
    camera = camera_from_camera_info(message, topic)
    rotation, projection = (tuple(float(number) for number in field) for field in (message.r, message.p))
    try:
        return CameraCalibration(camera, rotation, projection)
    except StereoLandmarkError as fault:
        raise CameraInfoError(f'{topic}: {fault}') from fault
