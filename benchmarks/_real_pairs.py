"""The room of EuRoC V1_01: two raw stereo pairs with their calibration and truth; displacements between pairs."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from _stereo_peers import FeaturePipeline, level_displacement
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_core.geometry import CameraMount, PinholeCamera, wrap_angle
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, stereo_rig
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.view_localizer import state_of
from stereo_landmark.files.camera_files import load_grey_image

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


def find_by_targets(localizer: LandmarkLocalizer, now: Moment) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the displacement found, as `true_displacement`, and its variances, shape (4,); NaN without a pose."""
    fix = localizer.locate(now.left, now.right, now.tilt)
    if not isinstance(fix, LandmarkFix):
        return np.full(4, np.nan), np.full(4, np.nan)
    return state_of(fix.displacement)[:4], fix.displacement.covariance.diagonal()


def find_by_features(
    taught: Moment, then: FeaturePipeline, now: Moment, pipeline: FeaturePipeline
) -> NDArray[np.float64]:
    """Return the displacement that pipelines with the cameras of then and of now find; NaN without a pose."""
    motion = pipeline.motion(then.teach((taught.left, taught.right)), pipeline.features(now.left))
    return np.full(4, np.nan) if motion is None else level_displacement(*motion, taught.tilt, pipeline.rig)


def load_real_pairs(folder: Path) -> RealPairs:
    """Load ``stereo_euroc/``.

    Raises:
        OSError: the truth cannot be read.
        ImageFileError: an image cannot be read.
    """
    truth = json.loads((folder / 'calibration_and_truth.json').read_text())
    calibrations = _calibrations(truth)
    rectifiers = [Rectifier(each) for each in calibrations]
    moments = {}
    for frame in truth['frames']:
        paths = (folder / f'{frame["t"]}_{side}.png' for side in ('left', 'right'))
        left, right = (each.rectify(load_grey_image(path)) for each, path in zip(rectifiers, paths, strict=True))
        w, x, y, z = frame['q_wxyz']
        R_room_base = Rotation.from_quat([x, y, z, w]).as_matrix() @ _R_BODY_BASE
        roll, pitch, yaw = Rotation.from_matrix(R_room_base).as_euler('xyz').tolist()
        moments[frame['role']] = Moment(left, right, np.array(frame['p']), (roll, pitch, yaw))
    T_body_left = np.array(truth['T_BS_cam0'])
    R_left_rectified = np.array(calibrations[0].rotation).reshape(3, 3).T
    R_base_optical = _R_BODY_BASE.T @ T_body_left[:3, :3] @ R_left_rectified
    a, b, c = Rotation.from_matrix(R_base_optical).as_euler('xyz').tolist()
    x, y, z = (_R_BODY_BASE.T @ T_body_left[:3, 3]).tolist()
    mount = CameraMount((x, y, z), (a, b, c))
    return RealPairs(stereo_rig(*calibrations, mount), moments)


def _calibrations(truth: dict[str, Any]) -> tuple[CameraCalibration, CameraCalibration]:
    """Return both calibrations as camera_calibration would write them."""
    left, right = (
        PinholeCamera(
            *(each['width'], each['height'], *each['intrinsics_fx_fy_cx_cy'], (*each['distortion_k1_k2_p1_p2'], 0.0))
        )
        for each in (truth['cam0'], truth['cam1'])
    )
    T_right_left = np.linalg.inv(np.array(truth['T_BS_cam1'])) @ np.array(truth['T_BS_cam0'])
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
