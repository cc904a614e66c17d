"""Calibration of a stereo pair as camera_calibration reports it, here without errors."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import PinholeCamera


@dataclass(frozen=True)
class CameraCalibration:
    """``camera_calibration`` result for one camera of a pair.

    Attributes:
        camera: intrinsics of the images as they come.
        rotation: shape (3, 3), from the camera's optical frame to the rectified one.
        projection: shape (3, 4), from the left camera's rectified frame into the rectified image; the right camera
            has -fx * baseline at [0, 3] [px m].
    """

    camera: PinholeCamera
    rotation: NDArray[np.float64]
    projection: NDArray[np.float64]


def rectified_pair(
    left: PinholeCamera, right: PinholeCamera, baseline: float
) -> tuple[CameraCalibration, CameraCalibration]:
    """Return the calibration of cameras whose images are rectified already.

    Args:
        left: intrinsics, without distortion.
        right: the same of the right camera.
        baseline: distance of the cameras [m].
    """
    shift = np.array([[-right.fx * baseline], [0.0], [0.0]])
    return (
        CameraCalibration(left, np.eye(3), np.hstack([left.matrix, np.zeros((3, 1))])),
        CameraCalibration(right, np.eye(3), np.hstack([right.matrix, shift])),
    )


def stereo_pair(
    left: PinholeCamera,
    right: PinholeCamera,
    right_xyz: NDArray[np.float64],
    R_left_right: NDArray[np.float64],
) -> tuple[CameraCalibration, CameraCalibration]:
    """Return the calibration of cameras that distort and look in slightly different directions.

    Args:
        left: intrinsics.
        right: intrinsics of the right camera, of the same image size.
        right_xyz: shape (3,), place of the right camera in the left one's optical frame [m].
        R_left_right: shape (3, 3), turns from the right camera's optical frame into the left one's.
    """
    R1, R2, P1, P2 = cv2.stereoRectify(
        left.matrix,
        np.array(left.distortion),
        right.matrix,
        np.array(right.distortion),
        (left.width, left.height),
        R_left_right.T,
        -R_left_right.T @ right_xyz.reshape(3, 1),
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=0.0,
    )[:4]
    return CameraCalibration(left, R1, P1), CameraCalibration(right, R2, P2)


def calibration_yaml(calibration: CameraCalibration, name: str) -> str:
    """Return the text of the file that camera_calibration writes for one camera.

    Args:
        calibration: calibration to write.
        name: camera name.
    """
    camera = calibration.camera
    parts = [
        f'image_width: {camera.width}\nimage_height: {camera.height}\ncamera_name: {name}\n',
        _matrix('camera_matrix', camera.matrix),
        'distortion_model: plumb_bob\n',
        _matrix('distortion_coefficients', np.array([camera.distortion])),
        _matrix('rectification_matrix', calibration.rotation),
        _matrix('projection_matrix', calibration.projection),
    ]
    return ''.join(parts)


def _matrix(name: str, values: NDArray[np.float64]) -> str:
    rows, cols = values.shape
    return f'{name}:\n  rows: {rows}\n  cols: {cols}\n  data: {values.ravel().tolist()}\n'
