"""Camera pose at an instant and its interpolation during a frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

_KNOTS = 5
"""Poses sampled per frame, with linear interpolation between them: at 1 m/s^2 an error of 2 um in 16 ms."""


@dataclass(frozen=True, eq=False)
class CameraPose:
    """Pose of a camera's optical frame in the map frame, ``T_map_camera``.

    Attributes:
        position: shape (3,), optical centre in the map frame [m].
        rotation: shape (3, 3), ``R_map_camera``.
    """

    position: NDArray[np.float64]
    rotation: NDArray[np.float64]

    def camera_points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points, shape (n, 3), from the map frame to the optical frame [m]."""
        return np.asarray((np.asarray(points, dtype=np.float64) - self.position) @ self.rotation)


PoseAt = Callable[[float], CameraPose]
"""Gives the camera's pose at a time [s]."""


def camera_pose(T_map_base: SE2, mount: CameraMount) -> CameraPose:
    """Return the pose of a camera on a robot.

    Args:
        T_map_base: pose of the robot.
        mount: the camera in ``base_link``, or, for a robot that sways, in the upright frame under it
            (``Suspension.mount_at``).
    """
    heading = matrix_from_rpy((0.0, 0.0, T_map_base.yaw))
    position = heading @ np.array(mount.xyz) + (T_map_base.x, T_map_base.y, 0.0)
    return CameraPose(np.asarray(position), heading @ mount.rotation)


class CameraMotion:
    """Camera trajectory during one frame."""

    def __init__(self, pose_at: PoseAt, start: float, stop: float) -> None:
        """Ask for the poses between two times [s]."""
        self._times = np.linspace(start, stop, _KNOTS)
        poses = [pose_at(float(time)) for time in self._times]
        self._positions = np.array([pose.position for pose in poses])
        self._middle = poses[_KNOTS // 2].rotation
        turns = self._middle.T @ np.array([pose.rotation for pose in poses])
        self._turns = Rotation.from_matrix(turns).as_rotvec()

    def poses(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return positions, shape (n, 3) [m], and ``R_map_camera``, shape (n, 3, 3), at times, shape (n,) [s]."""
        positions, turns = (
            np.column_stack([np.interp(times, self._times, column) for column in knots.T])
            for knots in (self._positions, self._turns)
        )
        return positions, self._middle @ _rotations(turns)

    def pose(self, time: float) -> CameraPose:
        """Return the pose at one time [s]."""
        positions, rotations = self.poses(np.array([time]))
        return CameraPose(positions[0], rotations[0])


def _rotations(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotation matrices, shape (n, 3, 3), of rotation vectors, shape (n, 3) [rad], by Rodrigues' formula.

    scipy's Rotation is too slow for the few poses that each lamp needs.
    """
    angles = np.linalg.norm(turns, axis=1)[:, None, None]
    cross = np.zeros((len(turns), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = turns
    cross[:, [1, 2, 0], [2, 0, 1]] = -turns
    half = np.sinc(0.5 * angles / np.pi)
    return np.asarray(np.eye(3) + np.sinc(angles / np.pi) * cross + 0.5 * half**2 * (cross @ cross))
