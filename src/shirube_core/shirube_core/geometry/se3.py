"""Poses in space, and rotation matrices of fixed-axis roll, pitch and yaw (REP-103)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class SE3:
    """A pose in SE(3): the pose of one frame in another, ``T_a_b`` as in `SE2`.

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
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 takes 0.2 s, and not every node rotates

    matrix: NDArray[np.float64] = Rotation.from_euler('xyz', np.asarray(rpy, dtype=np.float64)).as_matrix()
    return matrix
