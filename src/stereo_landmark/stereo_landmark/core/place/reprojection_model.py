"""Projection of taught points into both cameras of a displaced robot, with its Jacobians.

The state is ``(x, y, z, yaw, roll, pitch)``: pose of the base in the place's frame [m, rad].
A taught point X is at ``Rz(-yaw) (X - (x, y, z))`` in the current gravity-aligned frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import matrix_from_rpy
from stereo_landmark.core.place.stereo_rig import StereoRig

STATE_SIZE = 6
ROLL, PITCH = 4, 5
DEPTH_MIN = 0.05
"""Nearer points are not visible [m]."""


@dataclass(frozen=True)
class Reprojection:
    """Predicted pixels of taught points, with Jacobians.

    Attributes:
        pixels: predicted u, v left and u, v right, shape (n, 4) [px].
        state_jacobian: Jacobians of the pixels by the state, shape (n, 4, 6).
        point_jacobian: Jacobians of the pixels by the taught points, shape (n, 4, 3) [px/m].
        in_front: mask of the points in front of the cameras, shape (n,).
    """

    pixels: NDArray[np.float64]
    state_jacobian: NDArray[np.float64]
    point_jacobian: NDArray[np.float64]
    in_front: NDArray[np.bool_]


def reproject(state: NDArray[np.float64], taught: NDArray[np.float64], rig: StereoRig) -> Reprojection:
    """Project taught points into both cameras.

    Args:
        state: state of the robot, shape (6,).
        taught: taught points in the place's frame, shape (n, 3) [m].
        rig: stereo cameras.
    """
    R_place_level = matrix_from_rpy((0.0, 0.0, state[3]))
    R_level_base = matrix_from_rpy((state[ROLL], state[PITCH], 0.0))
    R_place_base = R_place_level @ R_level_base
    base = (taught - state[:3]) @ R_place_base
    optical = (base - np.array(rig.mount.xyz)) @ rig.mount.rotation
    in_front = optical[:, 2] > DEPTH_MIN
    safe = np.where(in_front[:, None], optical, [0.0, 0.0, 1.0])
    pixel_jacobian = rig.jacobians(safe)
    R_optical_base = rig.mount.rotation.T
    base_jacobian = np.zeros((len(taught), 3, STATE_SIZE))
    base_jacobian[:, :, :3] = -R_place_base.T
    level = (taught - state[:3]) @ R_place_level
    base_jacobian[:, :, 3] = np.column_stack([level[:, 1], -level[:, 0], np.zeros(len(level))]) @ R_level_base
    base_jacobian[:, :, ROLL] = np.cross(base, [1.0, 0.0, 0.0])
    base_jacobian[:, :, PITCH] = np.cross(base, [0.0, math.cos(state[ROLL]), -math.sin(state[ROLL])])
    return Reprojection(
        rig.project(safe),
        pixel_jacobian @ R_optical_base @ base_jacobian,
        pixel_jacobian @ (R_place_base @ rig.mount.rotation).T,
        in_front,
    )
