"""Camera pose in a gravity-aligned frame, from the tilt of the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry.camera_mount import CameraMount
from shirube_core.geometry.rotation import matrix_from_rpy


@dataclass(frozen=True)
class GravityAlignedCamera:
    """A camera's pose in the level frame: origin and yaw of the base, z against gravity.

    Attributes:
        rotation: ``R_level_camera``, shape (3, 3).
        position: position of the optical centre in the level frame, shape (3,) [m].
    """

    rotation: NDArray[np.float64]
    position: NDArray[np.float64]


def gravity_aligned_camera(mount: CameraMount, roll: float = 0.0, pitch: float = 0.0) -> GravityAlignedCamera:
    """Return the gravity-aligned camera of a tilted robot.

    Args:
        mount: extrinsics of the camera on the robot.
        roll: roll of the base about its x axis [rad].
        pitch: pitch of the base about its y axis [rad]; positive with the nose down.
    """
    R_level_base = matrix_from_rpy((roll, pitch, 0.0))
    return GravityAlignedCamera(R_level_base @ mount.rotation, R_level_base @ np.array(mount.xyz))
