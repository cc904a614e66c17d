"""3D rotations: fixed-axis roll, pitch, yaw (REP-103), matrices and quaternions (x, y, z, w)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def matrix_from_rpy(rpy: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation matrix of fixed-axis roll, pitch and yaw.

    Args:
        rpy: array-like, shape (3,), rotations about the parent's x, then y, then z axis [rad].

    Returns:
        array, shape (3, 3), ``R_parent_child``.
    """
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 takes 0.2 s, and not every node rotates

    matrix: NDArray[np.float64] = Rotation.from_euler('xyz', np.asarray(rpy, dtype=np.float64)).as_matrix()
    return matrix


def quaternion_from_yaw(yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion (x, y, z, w) of a rotation by ``yaw`` [rad] about z."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def yaw_from_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Return the yaw [rad] in the fixed-axis roll, pitch, yaw of a quaternion (x, y, z, w)."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
