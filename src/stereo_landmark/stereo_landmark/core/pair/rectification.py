"""Stereo rectification: undistorts images and aligns the rows of both cameras."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.pair.camera_calibration import CameraCalibration
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


class Rectifier:
    """Rectifies the images of one camera.

    Args:
        calibration: calibration of the camera.
    """

    def __init__(self, calibration: CameraCalibration) -> None:
        camera = calibration.raw
        self._size = (camera.width, camera.height)
        self._u, self._v = cv2.initUndistortRectifyMap(
            camera.matrix,
            np.array(camera.distortion),
            np.array(calibration.rotation).reshape(3, 3),
            calibration.matrix,
            self._size,
            cv2.CV_32FC1,
        )

    def rectify(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the rectified image, shape (h, w).

        The border is replicated outside the raw image, because a black border would look like a landmark.

        Args:
            image: raw grey image, shape (h, w).

        Raises:
            StereoLandmarkError: the image size differs from the calibration.
        """
        if image.shape[::-1] != self._size:
            raise StereoLandmarkError(
                f'the image is {image.shape[1]} x {image.shape[0]} px, the calibration is for '
                f'{self._size[0]} x {self._size[1]} px; calibrate at the resolution in use'
            )
        rectified = cv2.remap(image, self._u, self._v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(rectified, dtype=np.uint8)
