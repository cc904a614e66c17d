"""Calibrations of stereo pairs for tests, and their files."""

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from shirube_core.geometry import PinholeCamera
from stereo_landmark.core.pair.camera_pair import CameraCalibration


def rectified_calibration(camera, x=0.0):
    """Return the calibration of a camera that is already rectified."""
    projection = np.column_stack([camera.matrix, [-camera.fx * x, 0.0, 0.0]])
    return CameraCalibration(camera, tuple(np.eye(3).ravel()), tuple(projection.ravel().tolist()))


def raw_calibrations(left, right, rotation, shift):
    """Return both calibrations in the form of camera_calibration: X_right = rotation @ X_left + shift [m]."""
    size = (left.width, left.height)
    R_left, R_right, P_left, P_right, *_ = cv2.stereoRectify(
        *(left.matrix, np.array(left.distortion), right.matrix, np.array(right.distortion)),
        *(size, rotation, np.reshape(shift, (3, 1))),
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=0.0,
    )
    return tuple(
        CameraCalibration(camera, tuple(R.ravel().tolist()), tuple(P.ravel().tolist()))
        for camera, R, P in ((left, R_left, P_left), (right, R_right, P_right))
    )


def write_calibration(path, calibration):
    """Write the YAML of one camera."""

    def matrix(rows, columns, data):
        return {'rows': rows, 'cols': columns, 'data': [float(number) for number in data]}

    raw = calibration.raw
    content = {
        'image_width': raw.width,
        'image_height': raw.height,
        'camera_name': path.stem,
        'camera_matrix': matrix(3, 3, raw.matrix.ravel()),
        'distortion_model': 'plumb_bob',
        'distortion_coefficients': matrix(1, 5, raw.distortion),
        'rectification_matrix': matrix(3, 3, calibration.rotation),
        'projection_matrix': matrix(3, 4, calibration.projection),
    }
    path.write_text(yaml.safe_dump(content))
    return path


class RealPairs:
    """The EuRoC room: calibrations, and the raw teach and repeat pairs."""

    def __init__(self):
        folder = Path(os.environ.get('SHIRUBE_DATA', '')) / 'stereo_euroc'
        if not os.environ.get('SHIRUBE_DATA') or not folder.is_dir():
            pytest.skip('set SHIRUBE_DATA to the folder with stereo_euroc to run this')
        self.truth = json.loads((folder / 'calibration_and_truth.json').read_text())
        cameras, self.T_body_cameras = [], []
        for number in (0, 1):
            entry = self.truth[f'cam{number}']
            numbers = (*entry['intrinsics_fx_fy_cx_cy'], (*entry['distortion_k1_k2_p1_p2'], 0.0))
            cameras.append(PinholeCamera(entry['width'], entry['height'], *numbers))
            self.T_body_cameras.append(np.array(self.truth[f'T_BS_cam{number}']))
        T = np.linalg.inv(self.T_body_cameras[1]) @ self.T_body_cameras[0]
        self.calibrations = raw_calibrations(*cameras, T[:3, :3], T[:3, 3])
        self.paths = {
            frame['role']: [folder / f'{frame["t"]}_{side}.png' for side in ('left', 'right')]
            for frame in self.truth['frames']
        }

    def images(self, role):
        """Return the raw images of the teach or the repeat pair."""
        return [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in self.paths[role]]
