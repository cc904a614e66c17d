"""Where taught primitives are expected from supposed poses, many at once."""

from __future__ import annotations

import numpy as np
from numba import njit
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
    return np.asarray(_project(states, positions, view.camera.rotation, view.camera.position, lens_of(view)))


def poses_apart(
    states: NDArray[np.float64], positions: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return how far from poses points appear from where the first one has them, the farthest ones, shape (h,) [px].

    What one of both poses has behind it is left out; with nothing before them in common, poses are infinitely apart.

    Args:
        states: shape (h, 4), x, y, z [m] and yaw [rad] of the robot in the place's frame.
        positions: shape (k, 3), in the place's frame [m].
        view: the cameras, and how the robot leans.
    """
    pixels = expected_pixels(states, positions, view)[..., :2]
    ways = np.hypot(*(pixels - pixels[:1]).transpose(2, 0, 1))
    farthest = np.fmax.reduce(ways, axis=1)
    return np.where(np.isnan(farthest), np.inf, farthest)


def lens_of(view: StereoView) -> NDArray[np.float64]:
    """Return what compiled loops know of the cameras: fx, fy, cx, cy, fx and cx of the right one [px], baseline [m]."""
    left, right = view.rig.left, view.rig.right
    return np.array([left.fx, left.fy, left.cx, left.cy, right.fx, right.cx, view.rig.baseline])


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


@njit(cache=True, error_model='numpy')
def _project(
    states: NDArray[np.float64],
    positions: NDArray[np.float64],
    rotation: NDArray[np.float64],
    position: NDArray[np.float64],
    lens: NDArray[np.float64],
) -> NDArray[np.float64]:
    pixels = np.full((len(states), len(positions), 4), np.nan)
    optical = np.empty(3)
    for h in range(len(states)):
        cos, sin = np.cos(states[h, 3]), np.sin(states[h, 3])
        for k in range(len(positions)):
            x, y = positions[k, 0] - states[h, 0], positions[k, 1] - states[h, 1]
            ahead, left = cos * x + sin * y - position[0], cos * y - sin * x - position[1]
            up = positions[k, 2] - states[h, 2] - position[2]
            for c in range(3):
                optical[c] = rotation[0, c] * ahead + rotation[1, c] * left + rotation[2, c] * up
            if optical[2] > DEPTH_MIN:
                pixels[h, k, 0] = lens[0] * optical[0] / optical[2] + lens[2]
                pixels[h, k, 1] = lens[1] * optical[1] / optical[2] + lens[3]
                pixels[h, k, 2] = lens[4] * (optical[0] - lens[6]) / optical[2] + lens[5]
                pixels[h, k, 3] = pixels[h, k, 1]
    return pixels
