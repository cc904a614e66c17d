"""Poses in the plane, SE(2), and in space, SE(3): composition, inverse, rotations, and the covariance of a fitted pose.

``T_a_b`` is the pose of frame ``b`` in frame ``a``: it transforms coordinates in ``b`` to coordinates in ``a``.
So ``T_map_base @ T_base_camera`` is ``T_map_camera``. Rotations in space are fixed-axis roll, pitch and yaw (REP-103).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_angle(angle: float) -> float:
    """Wrap an angle [rad] to [-pi, pi]."""
    return math.remainder(angle, math.tau)


def quaternion_from_yaw(yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a rotation by ``yaw`` [rad] about z."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def yaw_from_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Return the yaw [rad] in the fixed-axis roll, pitch, yaw of a quaternion (x, y, z, w)."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def rotation_matrix(angle: float) -> NDArray[np.float64]:
    """Return the matrix of a rotation in the plane by an angle [rad], shape (2, 2)."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


@dataclass(frozen=True)
class SE2:
    """A pose in SE(2): the pose of one frame in another.

    Attributes:
        x: x of the child frame's origin in the parent frame [m].
        y: y of the child frame's origin in the parent frame [m].
        yaw: heading of the child frame in the parent frame [rad], counter-clockwise.
    """

    x: float
    y: float
    yaw: float

    def __matmul__(self, other: SE2) -> SE2:
        """Compose: ``T_a_b @ T_b_c`` is ``T_a_c``."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return SE2(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            wrap_angle(self.yaw + other.yaw),
        )

    def inverse(self) -> SE2:
        """Return ``T_b_a`` of ``T_a_b``."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return SE2(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, wrap_angle(-self.yaw))

    @classmethod
    def exp(cls, x: float, y: float, yaw: float) -> SE2:
        """Return the pose after a constant twist for one unit of time: the end of an arc (exponential map).

        Args:
            x: distance along the x axis of the moving frame [m].
            y: distance along its y axis [m].
            yaw: yaw change [rad].
        """
        half = 0.5 * yaw
        chord = math.sin(half) / half if half else 1.0  # ratio of chord and arc
        cos, sin = math.cos(half), math.sin(half)
        return cls(chord * x * cos - chord * y * sin, chord * x * sin + chord * y * cos, wrap_angle(yaw))

    def log(self) -> tuple[float, float, float]:
        """Return the constant twist (x [m], y [m], yaw [rad]) whose `exp` is this pose (logarithm map)."""
        yaw = wrap_angle(self.yaw)
        half = 0.5 * yaw
        arc = half / math.sin(half) if half else 1.0  # ratio of arc and chord
        cos, sin = math.cos(half), math.sin(half)
        return arc * (cos * self.x + sin * self.y), arc * (cos * self.y - sin * self.x), yaw

    def transform(self, points: ArrayLike) -> NDArray[np.float64]:
        """Transform points from the child frame to the parent frame.

        Args:
            points: array-like, shape (n, 2), coordinates in the child frame [m].

        Returns:
            array, shape (n, 2), the same points in the parent frame [m].
        """
        return np.asarray(points, dtype=np.float64) @ rotation_matrix(self.yaw).T + (self.x, self.y)

    def distance_to(self, other: SE2) -> float:
        """Return the distance between the origins of the two poses [m]."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def yaw_to(self, other: SE2) -> float:
        """Return the yaw from this pose to the other [rad], in [-pi, pi]."""
        return wrap_angle(other.yaw - self.yaw)


@dataclass(frozen=True, eq=False)
class SE3:
    """A pose in SE(3): the pose of one frame in another, ``T_a_b``.

    Attributes:
        rotation: ``R_a_b``, shape (3, 3).
        position: origin of the child frame in the parent frame, shape (3,) [m].
    """

    rotation: NDArray[np.float64]
    position: NDArray[np.float64]

    @classmethod
    def from_rpy(cls, xyz: ArrayLike, rpy: ArrayLike) -> SE3:
        """Return the pose at a position [m] with fixed-axis roll, pitch and yaw [rad]."""
        return cls(matrix_from_rpy(rpy), np.asarray(xyz, dtype=np.float64))

    def __matmul__(self, other: SE3) -> SE3:
        """Compose: ``T_a_b @ T_b_c`` is ``T_a_c``."""
        return SE3(self.rotation @ other.rotation, self.rotation @ other.position + self.position)

    def inverse(self) -> SE3:
        """Return ``T_b_a`` of ``T_a_b``."""
        return SE3(self.rotation.T, -self.rotation.T @ self.position)

    def transform(self, points: ArrayLike) -> NDArray[np.float64]:
        """Transform points, shape (n, 3), from the child frame to the parent frame."""
        moved: NDArray[np.float64] = np.asarray(points, dtype=np.float64) @ self.rotation.T + self.position
        return moved


def matrix_from_rpy(rpy: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix of fixed-axis roll, pitch and yaw.

    Args:
        rpy: array-like, shape (3,), rotations about the parent's x, then y, then z axis [rad].

    Returns:
        array, shape (3, 3), ``R_parent_child``.
    """
    roll, pitch, yaw = np.asarray(rpy, dtype=np.float64).tolist()
    a, b, c = math.cos(roll), math.cos(pitch), math.cos(yaw)
    d, e, f = math.sin(roll), math.sin(pitch), math.sin(yaw)
    return np.array(
        [
            [c * b, c * e * d - f * a, c * e * a + f * d],
            [f * b, f * e * d + c * a, f * e * a - c * d],
            [-e, b * d, b * a],
        ]
    )


def covariance_from_information(information: NDArray[np.float64], determinant_min: float) -> NDArray[np.float64] | None:
    """Return the covariance of a fitted pose, the inverse of its information matrix; None if that is singular.

    Args:
        information: information matrix of a least-squares fit, symmetric, shape (n, n); units may differ.
        determinant_min: smallest determinant of the matrix scaled to a unit diagonal.
    """
    diagonal = np.diag(information)
    if not np.isfinite(information).all() or not (diagonal > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(diagonal)
    scaled = information * scale * scale[:, None]
    if np.linalg.det(scaled) < determinant_min:
        return None
    return np.asarray(np.linalg.inv(scaled) * scale * scale[:, None])
