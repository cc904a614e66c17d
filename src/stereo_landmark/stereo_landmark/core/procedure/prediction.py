"""Predicts the pixels of taught primitives for many pose hypotheses, and the apparent centres of circles."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive

DEPTH_MIN = 0.2
"""Nearer points are not visible [m]."""


def predict_pixels(states: Floats, positions: Floats, view: StereoView) -> Floats:
    """Return predicted pixels, shape (h, k, 4): u, v left and u, v right [px]; NaN behind the cameras.

    Args:
        states: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (h, 4).
        positions: points in the place's frame, shape (k, 3) [m].
        view: stereo view with cameras and tilt.
    """
    return np.asarray(
        _project(states, positions, view.camera.rotation, view.camera.position, stereo_intrinsics(view))
    )


def image_distances(states: Floats, positions: Floats, view: StereoView) -> Floats:
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


def stereo_intrinsics(view: StereoView) -> Floats:
    """Return the intrinsics for the kernels: fx, fy, cx, cy, fx and cx of the right camera [px], baseline [m]."""
    left, right = view.rig.left, view.rig.right
    return np.array([left.fx, left.fy, left.cx, left.cy, right.fx, right.cx, view.rig.baseline])


def poses_from_match(taught: Floats, found: Floats, yaws: Floats) -> Floats:
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
    states: Floats, positions: Floats, rotation: Floats, position: Floats, intrinsics: Floats
) -> Floats:
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


WALL_TOLERANCE = 0.05
"""Maximum distance from a plane of landmarks that are on that wall [m]."""
WALL_WIDTH_MIN = 0.2
"""Minimum horizontal distance of two landmarks that determine the direction of a wall [m]."""


def wall_normal(position: Floats, others: Floats) -> Floats:
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


def centre_correction(taught: TaughtPrimitive, state: Floats, view: StereoView) -> Floats:
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


def _centre_offsets(taught: TaughtPrimitive, normal_place: Floats, state: Floats, view: StereoView) -> Floats:
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


def _line_normal(offsets: Floats) -> Floats:
    """Return the unit normal of the line through points and the origin, shape (2,)."""
    angle = 0.5 * math.atan2(
        2.0 * float(offsets[:, 0] @ offsets[:, 1]),
        float(offsets[:, 0] @ offsets[:, 0] - offsets[:, 1] @ offsets[:, 1]),
    )
    return np.array([-math.sin(angle), math.cos(angle)])


def ellipse_centre_offset(centre: Floats, normal: Floats, radius: float, camera: PinholeCamera) -> Floats:
    """Return the ellipse centre minus the projected circle centre, shape (2,) [px].

    The plane's homography maps the circle's conic into the image; the ellipse's centre is the pole of the
    line at infinity.

    Args:
        centre: circle centre in the optical frame, shape (3,) [m].
        normal: normal of the circle's plane, shape (3,), not necessarily a unit vector.
        radius: circle radius [m].
        camera: pinhole camera without distortion.
    """
    plane_axes = np.linalg.svd(normal[None, :])[2][1:]
    K = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    homography = K @ np.column_stack([radius * plane_axes[0], radius * plane_axes[1], centre])
    inverse = np.linalg.inv(homography)
    conic = inverse.T @ np.diag([1.0, 1.0, -1.0]) @ inverse
    ellipse_centre = -np.linalg.solve(conic[:2, :2], conic[:2, 2])
    projection = K @ (centre / centre[2])
    return np.asarray(ellipse_centre - projection[:2])
