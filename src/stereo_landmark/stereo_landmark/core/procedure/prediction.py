"""Where taught primitives are expected from supposed poses, many at once."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.procedure.stereo_view import StereoView

DEPTH_MIN = 0.2
"""Nearer things are not in view [m]."""


def expected_pixels(
    states: NDArray[np.float64], positions: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return where points are expected, shape (h, k, 4): u, v left and u, v right [px]; NaN behind the robot.

    Args:
        states: shape (h, 4), x, y, z [m] and yaw [rad] of the robot in the place's frame.
        positions: shape (k, 3), in the place's frame [m].
        view: the cameras, and how the robot leans.
    """
    ahead = positions[None] - states[:, None, :3]
    cos, sin = np.cos(states[:, 3, None]), np.sin(states[:, 3, None])
    level = np.stack(
        [cos * ahead[..., 0] + sin * ahead[..., 1], cos * ahead[..., 1] - sin * ahead[..., 0], ahead[..., 2]],
        axis=-1,
    )
    optical = ((level - view.camera.position) @ view.camera.rotation).reshape(-1, 3)
    in_front = optical[:, 2] > DEPTH_MIN
    pixels = view.rig.projections(np.where(in_front[:, None], optical, [0.0, 0.0, 1.0]))
    pixels[~in_front] = math.nan
    return pixels.reshape(len(states), len(positions), 4)


def states_through(
    taught: NDArray[np.float64], found: NDArray[np.float64], yaws: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the poses from which a taught point is where it was found, shape (n, h, 4): x, y, z, yaw.

    Args:
        taught: shape (3,), in the place's frame [m].
        found: shape (n, 3), in the level base frame of now [m].
        yaws: shape (h,) [rad].
    """
    cos, sin = np.cos(yaws), np.sin(yaws)
    x, y, z = (found[:, None, axis] for axis in range(3))
    states = np.empty((len(found), len(yaws), 4))
    states[..., 0] = taught[0] - (cos * x - sin * y)
    states[..., 1] = taught[1] - (sin * x + cos * y)
    states[..., 2] = taught[2] - z
    states[..., 3] = yaws
    return states
