"""A stereo rig on a robot, and its calibration as camera_calibration reports it."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor.shapes import PaintedScene
from scene_simulator.corridor.stereo_camera import StereoCamera
from scene_simulator.imaging.exposure import CameraPose, camera_pose
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy

FORWARD_MOUNT = CameraMount((0.1, 0.12, 1.25), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
"""The left camera: it looks along the robot's x axis, level, on a mast."""

RECTIFIED = StereoCamera(PinholeCamera(752, 480, 720.0, 720.0, 375.5, 239.5))


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


@dataclass(frozen=True)
class StereoRig:
    """Two cameras.

    Attributes:
        left: the left camera.
        right: the right one.
        right_xyz: place of the right camera in the left one's optical frame [m]; x is close to the baseline.
        right_rpy: its fixed-axis turn against the left one [rad]; none for images that are rectified already.
        mount: the left camera's optical frame on the robot.
    """

    left: StereoCamera = RECTIFIED
    right: StereoCamera = field(
        default_factory=lambda: StereoCamera(RECTIFIED.intrinsics, sensor=GainSensor(gain=0.97))
    )
    right_xyz: tuple[float, float, float] = (0.24, 0.0, 0.0)
    right_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mount: CameraMount = FORWARD_MOUNT

    @property
    def baseline(self) -> float:
        """Distance of the cameras [m]."""
        return math.hypot(*self.right_xyz)

    def camera_poses(self, T_map_base: SE2) -> tuple[CameraPose, CameraPose]:
        """Return ``T_map_left`` and ``T_map_right``."""
        left = camera_pose(T_map_base, self.mount)
        position = left.position + left.rotation @ self.right_xyz
        return left, CameraPose(position, left.rotation @ matrix_from_rpy(self.right_rpy))

    @property
    def is_rectified(self) -> bool:
        """Lenses do not distort, rows are the same in both images."""
        distortion = (*self.left.intrinsics.distortion, *self.right.intrinsics.distortion)
        return not any((*distortion, *self.right_rpy, *self.right_xyz[1:]))

    def calibrations(self) -> tuple[CameraCalibration, CameraCalibration]:
        """Return the exact calibration of the left and the right camera; rectified images keep their camera matrix."""
        left, right = self.left.intrinsics, self.right.intrinsics
        if self.is_rectified:
            shifts = np.zeros((3, 1)), np.array([[-right.fx * self.baseline], [0.0], [0.0]])
            P1, P2 = (np.hstack([camera.matrix, s]) for camera, s in zip((left, right), shifts, strict=True))
            return CameraCalibration(left, np.eye(3), P1), CameraCalibration(right, np.eye(3), P2)
        R_right_left = matrix_from_rpy(self.right_rpy).T
        R1, R2, P1, P2 = cv2.stereoRectify(
            left.matrix,
            np.array(left.distortion),
            right.matrix,
            np.array(right.distortion),
            (left.width, left.height),
            R_right_left,
            -R_right_left @ np.array(self.right_xyz).reshape(3, 1),
            flags=cv2.CALIB_ZERO_DISPARITY,
            alpha=0.0,
        )[:4]
        return CameraCalibration(left, R1, P1), CameraCalibration(right, R2, P2)


def raw_rig() -> StereoRig:
    """Return an unrectified rig: two slightly different distorting lenses, not quite parallel."""
    left = PinholeCamera(752, 480, 722.3, 721.6, 371.2, 243.8, (-0.281, 0.083, 0.0004, -0.0003, 0.0))
    right = PinholeCamera(752, 480, 719.1, 718.8, 380.4, 236.9, (-0.274, 0.077, -0.0005, 0.0002, 0.0))
    rpy = (math.radians(0.35), math.radians(-0.5), math.radians(0.25))
    return StereoRig(
        StereoCamera(left), StereoCamera(right, sensor=GainSensor(gain=0.97)), (0.2395, -0.0011, 0.0016), rpy
    )


def render_pair(
    scene: PaintedScene, rig: StereoRig, T_map_base: SE2, rng: np.random.Generator | None = None
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the pictures of the left and the right camera at a pose of the robot, each of shape (height, width).

    For a robot that leans, the mount is in the upright frame under it. Without a source of noise there is none.
    """
    left, right = rig.camera_poses(T_map_base)
    return rig.left.photograph(scene, left, rng), rig.right.photograph(scene, right, rng)
