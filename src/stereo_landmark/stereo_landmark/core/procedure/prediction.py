"""Predicts the pixels of taught primitives for many pose hypotheses at once."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.procedure.stereo_view import StereoView

DEPTH_MIN = 0.2
"""Nearer points are not visible [m]."""


def predict_pixels(
    states: NDArray[np.float64], positions: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return predicted pixels, shape (h, k, 4): u, v left and u, v right [px]; NaN behind the cameras.

    Args:
        states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
        positions: points in the place's frame, shape (k, 3) [m].
        view: stereo view with cameras and tilt.
    """
    return np.asarray(
        _project(states, positions, view.camera.rotation, view.camera.position, stereo_intrinsics(view))
    )


def image_distances(
    states: NDArray[np.float64], positions: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return the largest image distance of the points between each pose and the first pose, shape (h,) [px].

    Points behind the cameras of one of both poses are ignored; the distance is infinite if no point is visible in both.

    Args:
        states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
        positions: points in the place's frame, shape (k, 3) [m].
        view: stereo view with cameras and tilt.
    """
    pixels = predict_pixels(states, positions, view)[..., :2]
    distances = np.hypot(*(pixels - pixels[:1]).transpose(2, 0, 1))
    farthest = np.fmax.reduce(distances, axis=1)
    return np.where(np.isnan(farthest), np.inf, farthest)


def stereo_intrinsics(view: StereoView) -> NDArray[np.float64]:
    """Return the intrinsics for the kernels: fx, fy, cx, cy, fx and cx of the right camera [px], baseline [m]."""
    left, right = view.rig.left, view.rig.right
    return np.array([left.fx, left.fy, left.cx, left.cy, right.fx, right.cx, view.rig.baseline])


def poses_from_match(
    taught: NDArray[np.float64], found: NDArray[np.float64], yaws: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the poses that map a taught point to its matches, shape (n, h, 4): x, y, z [m], yaw [rad].

    Args:
        taught: taught point in the place's frame, shape (3,) [m].
        found: matched points in the current gravity-aligned base frame, shape (n, 3) [m].
        yaws: yaw hypotheses, shape (h,) [rad].
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
    intrinsics: NDArray[np.float64],
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
                pixels[h, k, 0] = intrinsics[0] * optical[0] / optical[2] + intrinsics[2]
                pixels[h, k, 1] = intrinsics[1] * optical[1] / optical[2] + intrinsics[3]
                pixels[h, k, 2] = intrinsics[4] * (optical[0] - intrinsics[6]) / optical[2] + intrinsics[5]
                pixels[h, k, 3] = pixels[h, k, 1]
    return pixels
