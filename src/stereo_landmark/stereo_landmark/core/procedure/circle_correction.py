"""Corrects the apparent centres of circles for the change of viewpoint."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import matrix_from_rpy
from stereo_landmark.core.place.circle_centre import ellipse_centre_offset
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive

WALL_TOLERANCE = 0.05
"""Maximum distance from a plane of landmarks that are on that wall [m]."""
WALL_WIDTH_MIN = 0.2
"""Minimum horizontal distance of two landmarks that determine the direction of a wall [m]."""


def wall_normal(position: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the normal of the vertical wall that a landmark is on, shape (3,), towards the robot.

    Walls are vertical, so landmarks on a wall are collinear in the horizontal plane. Of the lines through the landmark
    and another one, the line with the most landmarks is used; without such a line the wall faces the robot.

    Args:
        position: landmark in the place's frame, shape (3,) [m].
        others: landmarks around it, shape (n, 3) [m].
    """
    facing = -position[:2] / max(float(np.hypot(*position[:2])), 1e-9)
    offsets = others[:, :2] - position[:2]
    lengths = np.hypot(offsets[:, 0], offsets[:, 1])
    best, normal = 1, facing
    for i in np.flatnonzero(lengths >= WALL_WIDTH_MIN):
        along = offsets[i] / lengths[i]
        across = np.array([-along[1], along[0]])
        on_wall = np.abs(offsets @ across) <= WALL_TOLERANCE
        if on_wall.sum() > best:
            best = int(on_wall.sum())
            normal = _line_normal(offsets[on_wall])
    return np.array([*(normal if normal @ facing > 0.0 else -normal), 0.0])


def centre_correction(
    taught: TaughtPrimitive, state: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return how far the apparent centre of a circle moved on the wall since it was taught.

    Args:
        taught: taught primitive; the correction is zero for anything but circles.
        state: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        view: stereo view with cameras and tilt.

    Returns:
        correction of u, v left and u, v right, shape (4,) [px].
    """
    if taught.normal is None:
        return np.zeros(4)
    now, at_teaching = (_centre_offsets(taught, taught.normal, each, view) for each in (state, np.zeros(4)))
    return now - at_teaching


def _centre_offsets(
    taught: TaughtPrimitive, normal_place: NDArray[np.float64], state: NDArray[np.float64], view: StereoView
) -> NDArray[np.float64]:
    """Return the ellipse centre minus the circle centre in both images, shape (4,) [px]."""
    R_place_camera = matrix_from_rpy((0.0, 0.0, float(state[3]))) @ view.camera.rotation
    camera_position = state[:3] + matrix_from_rpy((0.0, 0.0, float(state[3]))) @ view.camera.position
    centre, normal = (taught.position - camera_position) @ R_place_camera, normal_place @ R_place_camera
    if centre[2] <= 0.0:
        return np.zeros(4)
    # The radius follows from the apparent size in the taught image.
    depth = float(((taught.position - view.camera.position) @ view.camera.rotation)[2])
    radius = taught.size * depth / view.rig.left.fx
    right = centre - [view.rig.baseline, 0.0, 0.0]
    return np.concatenate(
        [
            ellipse_centre_offset(centre, normal, radius, view.rig.left),
            ellipse_centre_offset(right, normal, radius, view.rig.right),
        ]
    )


def _line_normal(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit normal of the line through points and the origin, shape (2,)."""
    angle = 0.5 * math.atan2(
        2.0 * float(offsets[:, 0] @ offsets[:, 1]),
        float(offsets[:, 0] @ offsets[:, 0] - offsets[:, 1] @ offsets[:, 1]),
    )
    return np.array([-math.sin(angle), math.cos(angle)])
