"""Cramér-Rao bound of the robot's displacement from the panel's fields.

What is measured are the pixels along the outlines of the fields in four images, the pair that was taught and the one of
now, with the sensor's noise; unknown are the displacement, the corners in space, and the grey levels within and around
each field; blur and calibration are known, and the floor is level. The texts and scales within the fields, and that
fields are rectangles, would add information, and the method does not use it either.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from _landmark_views import RIG, LandmarkView, LandmarkWall
from _stereo_peers import product_rig
from numpy.typing import NDArray
from scipy.special import ndtr

from scene_simulator.gain_sensor import GainSensor
from scene_simulator.stereo_camera import StereoCamera
from shirube_core.geometry import SE2
from stereo_landmark.core.place.reprojection_model import Reprojection, reproject

CAMERAS = product_rig(RIG)
STATE = 4
"""x, y, z and yaw."""
PIXEL_VARIANCE = 1.0 / 12.0
"""Of a square pixel along any direction [px²]; also of rounding to whole grey levels."""
MARGIN = 4
STEP = 1e-3
SURE = 1e-4
"""Pixels covered less than this fraction, or more than its complement, are not used for the outline."""


class PoseBound:
    """The bound for displacements from one lesson.

    Args:
        wall: the scene.
        lesson: when it was taught.
        fields: numbers of the taught fields.
    """

    def __init__(self, wall: LandmarkWall, lesson: LandmarkView, fields: Sequence[int]) -> None:
        inverse = lesson.T_map_base.inverse()
        self._taught = []
        for corners in wall.field_corners()[list(fields)]:
            points = np.column_stack([inverse.transform(corners[:, :2]), corners[:, 2]])
            noise, view = _measured(lesson, points, np.zeros(6))
            by_points = _block_diagonal(view.point_jacobian)
            known = np.linalg.inv(by_points.T @ np.linalg.solve(noise, by_points))
            self._taught.append((points, known))

    def covariance(self, view: LandmarkView, T_lesson_base: SE2) -> NDArray[np.float64]:
        """Return the bound of x, y, z [m] and yaw [rad] in the taught frame, shape (4, 4)."""
        information = np.zeros((STATE, STATE))
        state = np.array([T_lesson_base.x, T_lesson_base.y, 0.0, T_lesson_base.yaw, 0.0, 0.0])
        for points, known in self._taught:
            noise, seen = _measured(view, points, state)
            by_points = _block_diagonal(seen.point_jacobian)
            state_jacobian = seen.state_jacobian[:, :, :STATE].reshape(-1, STATE)
            spread = noise + by_points @ known @ by_points.T
            information += state_jacobian.T @ np.linalg.solve(spread, state_jacobian)
        return np.asarray(np.linalg.inv(information))


def outline_coverage(
    corners: NDArray[np.float64], columns: NDArray[np.float64], rows: NDArray[np.float64], blur: float
) -> NDArray[np.float64]:
    """Return how much of pixels a convex quadrilateral covers, seen through a Gaussian blur, shape (n,).

    Near a corner of about a right angle both sides act independently.

    Args:
        corners: shape (4, 2), clockwise as seen in an image [px].
        columns: columns of the pixels, shape (n,).
        rows: rows of the pixels, shape (n,).
        blur: standard deviation, the square of the pixel included [px].
    """
    covered = np.ones(len(columns))
    for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - begin) / math.hypot(*(end - begin))
        inside = along[0] * (rows - begin[1]) - along[1] * (columns - begin[0])
        covered *= ndtr(inside / blur)
    return covered


def outline_covariance(
    image: NDArray[np.uint8], corners: NDArray[np.float64], camera: StereoCamera
) -> NDArray[np.float64]:
    """Return the bound of the covariance of four corners from the pixels along their outline, shape (8, 8) [px²].

    Args:
        image: shape (h, w), grey image with the levels along the outline.
        corners: shape (4, 2), clockwise [px].
        camera: its blur and noise.
    """
    blur = math.sqrt(camera.optics.blur**2 + PIXEL_VARIANCE)
    (left, top), (right, bottom) = (
        np.floor(corners.min(axis=0)).astype(int) - MARGIN,
        np.ceil(corners.max(axis=0)).astype(int) + MARGIN + 1,
    )
    rows, columns = (grid.ravel() for grid in np.mgrid[top:bottom, left:right])
    covered = outline_coverage(corners, columns, rows, blur)
    partly = (covered > SURE) & (covered < 1.0 - SURE)
    rows, columns, covered = rows[partly], columns[partly], covered[partly]
    changes = []
    for k in range(corners.size):
        step = np.zeros(corners.size)
        step[k] = STEP
        ahead, behind = (
            outline_coverage(corners + sign * step.reshape(4, 2), columns, rows, blur) for sign in (1, -1)
        )
        changes.append((ahead - behind) / (2.0 * STEP))
    by_corners = np.column_stack(changes)
    grey = image[rows, columns].astype(np.float64)
    # The levels on both sides of the outline are those that explain the pixels on it.
    sides = np.column_stack([1.0 - covered, covered])
    outside, inside = np.linalg.lstsq(sides, grey, rcond=None)[0]
    jacobian = np.column_stack([(inside - outside) * by_corners, sides])
    weights = 1.0 / grey_variance(outside + (inside - outside) * covered, camera.sensor)
    covariance = np.linalg.inv(jacobian.T @ (jacobian * weights[:, None]))
    return np.asarray(covariance[: corners.size, : corners.size])


def grey_variance(levels: NDArray[np.float64], sensor: GainSensor) -> NDArray[np.float64]:
    """Return the variance of grey levels, shape (n,): shot noise, read-out and rounding."""
    scale = 255.0 * sensor.gain / sensor.full_well
    electrons = np.maximum(levels - 255.0 * sensor.black_level, 0.0) / scale
    return np.asarray((electrons + sensor.read_noise**2) * scale**2 + PIXEL_VARIANCE)


def _measured(
    view: LandmarkView, points: NDArray[np.float64], state: NDArray[np.float64]
) -> tuple[NDArray[np.float64], Reprojection]:
    """Return the bound of u, v left and u, v right of four corners, shape (16, 16) [px²], and how they are seen."""
    seen = reproject(state, points, CAMERAS)
    noise = np.zeros((4, 4, 4, 4))
    for image, camera, first in zip(view.panel, (RIG.left, RIG.right), (0, 2), strict=True):
        part = slice(first, first + 2)
        bound = outline_covariance(image, seen.pixels[:, part], camera)
        noise[:, part, :, part] = bound.reshape(4, 2, 4, 2)
    return noise.reshape(16, 16), seen


def _block_diagonal(blocks: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return blocks of shape (n, a, b) along the diagonal of a matrix of shape (n a, n b)."""
    n, a, b = blocks.shape
    matrix = np.zeros((n, a, n, b))
    matrix[np.arange(n), :, np.arange(n)] = blocks
    return matrix.reshape(n * a, n * b)
