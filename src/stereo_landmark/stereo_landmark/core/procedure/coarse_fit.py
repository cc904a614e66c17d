"""The pose that fits primitives as they were detected: good enough to look where it puts all others.

It weighs as `core.place.reprojection_fit` does, which fits the displacement itself to measured points; but detected
coordinates all have the same noise, and roll and pitch are known. So many suppositions are tried in a millisecond.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.procedure.prediction import lens_of
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.symmetric_matrix import invert_symmetric

DETECTED_SIGMA = 0.7
"""How well a detected primitive is known before it is measured in the grey image [px]."""
HUBER = 3.0
"""Standard deviations of a point beyond which its pull grows no more."""
STEPS_MAX = 20
STEP_DONE = 1e-5
"""A step smaller than this [m, rad] ends the fit."""
DEPTH_MIN = 0.05
"""Nearer points are not in view [m]."""


def coarse_fit(
    start: NDArray[np.float64],
    taught: NDArray[np.float64],
    covariances: NDArray[np.float64],
    seen: NDArray[np.float64],
    view: StereoView,
) -> NDArray[np.float64] | None:
    """Return x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,), None where points tell none.

    Args:
        start: shape (4,), about where it is.
        taught: shape (n, 3), in the place's frame [m].
        covariances: shape (n, 3, 3), of the taught points [m²].
        seen: shape (n, 4), u, v left and u, v right [px].
        view: the cameras, and how the robot leans.
    """
    if len(seen) < 2:
        return None
    state = start.copy()
    camera = view.camera
    is_known = _fit(state, taught, covariances, seen, camera.rotation, camera.position, lens_of(view))
    return state if is_known else None


@njit(cache=True, error_model='numpy')
def _fit(
    state: NDArray[np.float64],
    taught: NDArray[np.float64],
    covariances: NDArray[np.float64],
    seen: NDArray[np.float64],
    rotation: NDArray[np.float64],
    position: NDArray[np.float64],
    lens: NDArray[np.float64],
) -> bool:
    """Write the fitted state by Gauss-Newton steps with weights; return whether points determine it."""
    information, gradient, inverse = np.empty((4, 4)), np.empty(4), np.empty((4, 4))
    for _ in range(STEPS_MAX):
        _sum_up(state, taught, covariances, seen, (rotation, position, lens), information, gradient)
        if not invert_symmetric(information, inverse):
            return False
        longest = 0.0
        for i in range(4):
            step = 0.0
            for j in range(4):
                step += inverse[i, j] * gradient[j]
            state[i] += step
            longest = max(longest, abs(step))
        if longest < STEP_DONE:
            break
    state[3] = (state[3] + np.pi) % (2.0 * np.pi) - np.pi
    return True


@njit(cache=True, error_model='numpy')
def _sum_up(
    state: NDArray[np.float64],
    taught: NDArray[np.float64],
    covariances: NDArray[np.float64],
    seen: NDArray[np.float64],
    camera: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    information: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> None:
    """Write the normal equations of a step; the camera is its rotation, position and lens."""
    jacobian, residual, weights = np.empty((3, 4)), np.empty(3), np.empty((3, 3))
    information[:], gradient[:] = 0.0, 0.0
    for n in range(len(taught)):
        if not _linearised(state, taught[n], seen[n], camera, jacobian, residual):
            continue
        _weigh(jacobian, residual, covariances[n], seen[n, 1] - seen[n, 3], weights)
        for i in range(4):
            for m in range(3):
                pull = 0.0
                for k in range(3):
                    pull += jacobian[k, i] * weights[k, m]
                gradient[i] += pull * residual[m]
                for j in range(4):
                    information[i, j] += pull * jacobian[m, j]


@njit(cache=True, error_model='numpy')
def _weigh(
    jacobian: NDArray[np.float64],
    residual: NDArray[np.float64],
    covariance: NDArray[np.float64],
    row_difference: float,
    weights: NDArray[np.float64],
) -> None:
    """Write the inverse covariance of u left, mean v and u right, less for what lies off (Huber)."""
    variance = DETECTED_SIGMA**2
    # A taught point moves its picture as the robot does, the other way.
    s = np.zeros((3, 3))
    for i in range(3):
        s[i, i] = 0.5 * variance if i == 1 else variance
        for j in range(3):
            for k in range(3):
                for m in range(3):
                    s[i, j] += jacobian[i, k] * covariance[k, m] * jacobian[j, m]
    for i in range(3):
        for j in range(3):
            a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            weights[i, j] = s[a, c] * s[b, d] - s[a, d] * s[b, c]
    weights /= s[0, 0] * weights[0, 0] + s[0, 1] * weights[0, 1] + s[0, 2] * weights[0, 2]
    squares = 0.5 * row_difference**2 / variance
    for i in range(3):
        for j in range(3):
            squares += residual[i] * weights[i, j] * residual[j]
    weights *= min(1.0, HUBER / max(np.sqrt(squares), 1e-9))


@njit(cache=True, error_model='numpy')
def _linearised(
    state: NDArray[np.float64],
    taught: NDArray[np.float64],
    seen: NDArray[np.float64],
    camera: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    jacobian: NDArray[np.float64],
    residual: NDArray[np.float64],
) -> bool:
    """Write residuals and derivatives of u left, mean v and u right of a point; return whether it is in view."""
    rotation, position, lens = camera
    cos, sin = np.cos(state[3]), np.sin(state[3])
    dx, dy = taught[0] - state[0], taught[1] - state[1]
    ahead, left, up = cos * dx + sin * dy, cos * dy - sin * dx, taught[2] - state[2]
    optical, motion = np.empty(3), np.empty((3, 4))
    for c in range(3):
        a, b, d = rotation[0, c], rotation[1, c], rotation[2, c]
        optical[c] = a * (ahead - position[0]) + b * (left - position[1]) + d * (up - position[2])
        motion[c, 0], motion[c, 1] = -a * cos + b * sin, -a * sin - b * cos
        motion[c, 2], motion[c, 3] = -d, a * left - b * ahead
    x, y, z = optical
    if z <= DEPTH_MIN:
        return False
    for i in range(4):
        jacobian[0, i] = lens[0] / z * (motion[0, i] - x / z * motion[2, i])
        jacobian[1, i] = lens[1] / z * (motion[1, i] - y / z * motion[2, i])
        jacobian[2, i] = lens[4] / z * (motion[0, i] - (x - lens[6]) / z * motion[2, i])
    residual[0] = seen[0] - lens[0] * x / z - lens[2]
    residual[1] = 0.5 * (seen[1] + seen[3]) - lens[1] * y / z - lens[3]
    residual[2] = seen[2] - lens[4] * (x - lens[6]) / z - lens[5]
    return True
