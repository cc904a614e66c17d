"""Measurement model: bearings to lamps at a robot pose, and their Jacobian.

The state is ``(x, y, z, yaw, tilt_x, tilt_y)``: the base in the map [m, rad], and the error of the known tilt as a
rotation vector in the level frame [rad]. A lamp L is in the optical frame at
``R_level_camera^T (exp(-tilt) l - t)`` with l the lamp in the level frame and t the camera in it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE3, matrix_from_rpy

STATES = 6
_ROTATION_90 = np.array([[0.0, -1.0], [1.0, 0.0]])


def camera_points(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64], camera: SE3
) -> NDArray[np.float64]:
    """Return the lamp positions, shape (n, 3), in the optical frame [m]; ``motions`` as in `LampRays`."""
    tilted = _level_points(state, lamps, motions) @ _tilt_matrix(state)
    return np.asarray((tilted - camera.position) @ camera.rotation)


def projections_with_jacobian(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64], camera: SE3
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the rays to the lamps, their Jacobian and the depths; arguments as in `camera_points`.

    Returns:
        rays with z = 1, shape (n, 2); their Jacobian with respect to the state, shape (n, 2, 6); depths, shape (n,)
        [m], not positive for lamps behind the camera.
    """
    level = _level_points(state, lamps, motions)
    tilt = _tilt_matrix(state)
    tilted = level @ tilt
    points = (tilted - camera.position) @ camera.rotation
    pose_derivatives = _level_derivatives(state, level, motions) @ tilt
    zero = np.zeros(len(lamps))
    turned_x = np.column_stack([zero, tilted[:, 2], -tilted[:, 1]])
    turned_y = np.column_stack([-tilted[:, 2], zero, tilted[:, 0]])
    changes = np.concatenate([pose_derivatives, turned_x[:, None], turned_y[:, None]], axis=1) @ camera.rotation
    depths = points[:, 2]
    safe = np.where(np.abs(depths) > 1e-9, depths, 1e-9)
    rays = points[:, :2] / safe[:, None]
    jacobian = (changes[:, :, :2] - rays[:, None, :] * changes[:, :, 2:]) / safe[:, None, None]
    return rays, jacobian.transpose(0, 2, 1), depths


def _level_points(
    state: NDArray[np.float64], lamps: NDArray[np.float64], motions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the lamps in the level frame at the time of each observation, shape (n, 3)."""
    x, y, z, yaw = state[:4]
    cos, sin = math.cos(yaw), math.sin(yaw)
    ahead = (lamps[:, :2] - (x, y)) @ np.array([[cos, -sin], [sin, cos]]) - motions[:, :2]
    turn_cos, turn_sin = np.cos(motions[:, 2]), np.sin(motions[:, 2])
    return np.column_stack(
        [
            turn_cos * ahead[:, 0] + turn_sin * ahead[:, 1],
            turn_cos * ahead[:, 1] - turn_sin * ahead[:, 0],
            lamps[:, 2] - z,
        ]
    )


def _level_derivatives(
    state: NDArray[np.float64], level: NDArray[np.float64], motions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the derivatives of the points in the level frame with respect to x, y, z and yaw, shape (n, 4, 3)."""
    angles = state[3] + motions[:, 2]
    cos, sin = np.cos(angles), np.sin(angles)
    turn_cos, turn_sin = np.cos(motions[:, 2]), np.sin(motions[:, 2])
    # Translation to the position of the observation, in the level frame at that time.
    offset_x = turn_cos * motions[:, 0] + turn_sin * motions[:, 1]
    offset_y = turn_cos * motions[:, 1] - turn_sin * motions[:, 0]
    derivatives = np.zeros((len(level), 4, 3))
    derivatives[:, 0, 0], derivatives[:, 0, 1] = -cos, sin
    derivatives[:, 1, 0], derivatives[:, 1, 1] = -sin, -cos
    derivatives[:, 2, 2] = -1.0
    lever_arm = level[:, :2] + np.column_stack([offset_x, offset_y])
    derivatives[:, 3, :2] = lever_arm @ _ROTATION_90
    return derivatives


def _tilt_matrix(state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``exp(tilt)``; for small errors roll and pitch commute."""
    if not state[4:].any():
        return np.eye(3)
    return matrix_from_rpy((state[4], state[5], 0.0))
