"""Extrinsics of a camera on the robot, its projection to the floor, and its pose on a tilted robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_core.geometry.se3 import SE3, matrix_from_rpy


@dataclass(frozen=True)
class CameraMount:
    """Pose of a camera's optical frame in ``base_link``, whose z = 0 plane is the floor.

    Attributes:
        xyz: position of the optical centre in the base frame [m].
        rpy: fixed-axis roll, pitch, yaw of the optical frame in the base frame [rad].
            ``(pi, 0, -pi/2)`` looks straight down; the upper edge of the image is at the front.
    """

    xyz: tuple[float, float, float] = (0.0, 0.0, 0.13)
    rpy: tuple[float, float, float] = (math.pi, 0.0, -math.pi / 2.0)

    @cached_property
    def rotation(self) -> NDArray[np.float64]:
        """``R_base_camera``, shape (3, 3), read-only."""
        rotation = matrix_from_rpy(self.rpy)
        rotation.flags.writeable = False
        return rotation

    def floor_points_from_rays(self, rays: ArrayLike) -> NDArray[np.float64]:
        """Intersect rays of the camera with the floor.

        Args:
            rays: array-like, shape (n, 3), directions in the optical frame.

        Returns:
            array, shape (n, 2), x and y in the base frame [m]; NaN for a ray that does not point down.
        """
        directions = np.asarray(rays, dtype=np.float64) @ self.rotation.T
        x, y, z = self.xyz
        with np.errstate(divide='ignore', invalid='ignore'):
            scale = np.where(directions[:, 2] < 0.0, -z / directions[:, 2], np.nan)
        return np.column_stack([x + scale * directions[:, 0], y + scale * directions[:, 1]])

    def camera_points_from_floor(self, points: ArrayLike) -> NDArray[np.float64]:
        """Transform floor points from the base frame to the optical frame.

        Args:
            points: array-like, shape (n, 2), x and y in the base frame [m], on the floor.

        Returns:
            array, shape (n, 3), in the optical frame [m].
        """
        floor = np.asarray(points, dtype=np.float64)
        base = np.column_stack([floor, np.zeros(len(floor))])
        return (base - np.array(self.xyz)) @ self.rotation


def gravity_aligned_camera(mount: CameraMount, roll: float = 0.0, pitch: float = 0.0) -> SE3:
    """Return the pose of a tilted robot's camera in the level frame: origin and yaw of the base, z against gravity.

    Args:
        mount: extrinsics of the camera on the robot.
        roll: roll of the base about its x axis [rad].
        pitch: pitch of the base about its y axis [rad]; positive with the nose down.
    """
    T_level_base = SE3.from_rpy((0.0, 0.0, 0.0), (roll, pitch, 0.0))
    return T_level_base @ SE3(mount.rotation, np.array(mount.xyz))
