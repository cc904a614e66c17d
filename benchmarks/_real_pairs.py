"""The room of EuRoC V1_01: two raw stereo pairs with their calibration, and the truth of both moments."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_core.geometry import CameraMount, PinholeCamera, wrap_angle
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, stereo_rig
from stereo_landmark.core.stereo import StereoRig

# The body is an IMU with x up, y right and z ahead; the base has x ahead, y left and z up.
_R_BODY_BASE = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])


class Moment(NamedTuple):
    """A pair of rectified grey images, and the true position, shape (3,) [m], roll, pitch and yaw [rad] of the base."""

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    position: NDArray[np.float64]
    rpy: tuple[float, float, float]

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base [rad]."""
        return self.rpy[:2]


class RealPairs(NamedTuple):
    """Both moments, by role ('teach', 'repeat'), and the rectified cameras."""

    rig: StereoRig
    moments: dict[str, Moment]


def true_displacement(taught: Moment, now: Moment) -> NDArray[np.float64]:
    """Return x, y, z [m] and yaw [rad] of the base now in the level base frame of the taught moment, shape (4,)."""
    shift = Rotation.from_euler('z', -taught.rpy[2]).apply(now.position - taught.position)
    return np.array([*shift, wrap_angle(now.rpy[2] - taught.rpy[2])])


def load_real_pairs(folder: Path) -> RealPairs:
    """Load ``stereo_euroc/``.

    Raises:
        OSError: a file cannot be read.
    """
    truth = json.loads((folder / 'calibration_and_truth.json').read_text())
    calibrations = _calibrations(truth)
    rectifiers = [Rectifier(each) for each in calibrations]
    moments = {}
    for frame in truth['frames']:
        images = []
        for side, rectifier in zip(('left', 'right'), rectifiers, strict=True):
            path = folder / f'{frame["t"]}_{side}.png'
            raw = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
            if raw is None:
                raise OSError(f'{path}: no image')
            images.append(rectifier.rectify(np.asarray(raw, dtype=np.uint8)))
        w, x, y, z = frame['q_wxyz']
        R_room_base = Rotation.from_quat([x, y, z, w]).as_matrix() @ _R_BODY_BASE
        rpy = tuple(float(angle) for angle in Rotation.from_matrix(R_room_base).as_euler('xyz'))
        moments[frame['role']] = Moment(images[0], images[1], np.array(frame['p']), (rpy[0], rpy[1], rpy[2]))
    T_body_left = np.array(truth['T_BS_cam0'])
    R_left_rectified = np.array(calibrations[0].rotation).reshape(3, 3).T
    R_base_optical = _R_BODY_BASE.T @ T_body_left[:3, :3] @ R_left_rectified
    a, b, c = Rotation.from_matrix(R_base_optical).as_euler('xyz').tolist()
    x, y, z = (_R_BODY_BASE.T @ T_body_left[:3, 3]).tolist()
    mount = CameraMount((x, y, z), (a, b, c))
    return RealPairs(stereo_rig(*calibrations, mount), moments)


def _calibrations(truth: dict[str, Any]) -> tuple[CameraCalibration, CameraCalibration]:
    """Return both calibrations as camera_calibration would write them."""
    cameras, poses = [], []
    for entry, pose in ((truth['cam0'], 'T_BS_cam0'), (truth['cam1'], 'T_BS_cam1')):
        fx, fy, cx, cy = entry['intrinsics_fx_fy_cx_cy']
        k1, k2, p1, p2 = entry['distortion_k1_k2_p1_p2']
        cameras.append(PinholeCamera(entry['width'], entry['height'], fx, fy, cx, cy, (k1, k2, p1, p2, 0.0)))
        poses.append(np.array(truth[pose]))
    T_right_left = np.linalg.inv(poses[1]) @ poses[0]
    left, right = cameras
    R_left, R_right, P_left, P_right, *_ = cv2.stereoRectify(
        *(left.matrix, np.array(left.distortion), right.matrix, np.array(right.distortion)),
        *((left.width, left.height), T_right_left[:3, :3], T_right_left[:3, 3:]),
        flags=cv2.CALIB_ZERO_DISPARITY,
        alpha=0.0,
    )
    rectified = (left, R_left, P_left), (right, R_right, P_right)
    first, second = (
        CameraCalibration(camera, tuple(R.ravel().tolist()), tuple(P.ravel().tolist())) for camera, R, P in rectified
    )
    return first, second
