"""A stereo rig on a robot, and its calibration as camera_calibration reports it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from scene_simulator.camera_motion import CameraPose, camera_pose
from scene_simulator.gain_sensor import GainSensor
from scene_simulator.renderable_scene import PaintedScene
from scene_simulator.stereo_calibration import CameraCalibration, rectified_pair, stereo_pair
from scene_simulator.stereo_camera import StereoCamera
from shirube_core.geometry import SE2, CameraMount, PinholeCamera, matrix_from_rpy

FORWARD_MOUNT = CameraMount((0.1, 0.12, 1.25), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
"""The left camera: it looks along the robot's x axis, level, on a mast."""

RECTIFIED = StereoCamera(PinholeCamera(752, 480, 720.0, 720.0, 375.5, 239.5))


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
        """Return the exact calibration of the left and the right camera.

        Images that are rectified already keep their camera matrix and are not turned.
        """
        left, right = self.left.intrinsics, self.right.intrinsics
        if self.is_rectified:
            return rectified_pair(left, right, self.baseline)
        return stereo_pair(left, right, np.array(self.right_xyz), matrix_from_rpy(self.right_rpy))


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
    """Return the pictures of the left and the right camera, each of shape (height, width).

    Args:
        scene: what there is to see, such as a corridor.
        rig: the cameras; for a robot that leans, with the mount in the upright frame under it.
        T_map_base: pose of the robot.
        rng: source of the sensors' noise, none for pictures without.
    """
    left, right = rig.camera_poses(T_map_base)
    return rig.left.photograph(scene, left, rng), rig.right.photograph(scene, right, rng)
