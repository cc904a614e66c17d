"""The picture of a circle: an ellipse, and not quite where the picture of its centre is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor.shapes import RoundLandmark
from scene_simulator.imaging.exposure import CameraPose
from shirube_core.geometry import PinholeCamera


@dataclass(frozen=True)
class CircleImage:
    """An ellipse in a picture.

    Attributes:
        centre: u and v [px].
        semi_axes: the longer and the shorter one [px].
        tilt: angle of the major axis, from u towards v, -pi/2 to pi/2 [rad].
    """

    centre: tuple[float, float]
    semi_axes: tuple[float, float]
    tilt: float


def circle_image(circle: RoundLandmark, camera: PinholeCamera, pose: CameraPose) -> CircleImage:
    """Return the picture of a circle behind a lens without distortion.

    A homography H takes the conic C of the circle to ``H^-T C H^-1``; the ellipse is read from that.

    Args:
        circle: all of it before the camera.
        camera: its distortion is left out.
        pose: ``T_map_camera``.
    """
    u, v = circle.centre
    origin, right, up = pose.camera_points(circle.surface.points_map([(u, v), (u + 1.0, v), (u, v + 1.0)]))
    plane_from_pixels = np.linalg.inv(camera.matrix @ np.column_stack([right - origin, up - origin, origin]))
    conic = plane_from_pixels.T @ np.diag([1.0, 1.0, -(circle.radius**2)]) @ plane_from_pixels
    quadratic, linear = conic[:2, :2], conic[:2, 2]
    centre = -np.linalg.solve(quadratic, linear)
    value = -(conic[2, 2] + linear @ centre)
    eigenvalues, axes = np.linalg.eigh(quadratic * math.copysign(1.0, float(value)))
    longer, shorter = np.sqrt(abs(float(value)) / eigenvalues).tolist()
    tilt = math.remainder(math.atan2(axes[1, 0], axes[0, 0]), math.pi)
    return CircleImage((float(centre[0]), float(centre[1])), (longer, shorter), tilt)
