"""The dots of one image of a survey."""

from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Booleans, Floats
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2, CameraMount, PinholeCamera


@dataclass(frozen=True)
class SurveyImage:
    """The dots of an image in the base frame.

    Attributes:
        name: name of the image, for messages.
        T_odom_base: pose of the robot by odometry.
        directions: rays to the dots in the base frame of the level robot, shape (n, 3).
        points: positions of the dots on the floor for the level robot, shape (n, 2) [m].
        sigmas: standard deviation of a dot along each axis on the floor, shape (n,) [m].
        diameters: diameters of the dots on the floor, shape (n,) [m].
    """

    name: str
    T_odom_base: SE2
    directions: Floats
    points: Floats
    sigmas: Floats
    diameters: Floats

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.points)


def survey_image(
    name: str, T_odom_base: SE2, dots: DetectedDots, camera: PinholeCamera, mount: CameraMount
) -> SurveyImage:
    """Return the dots of an image in the base frame; dots above the horizon are left out."""
    rays = camera.rays_from_pixels(dots.pixels)
    points = mount.floor_points_from_rays(rays)
    below = np.isfinite(points).all(axis=1)
    metres_per_pixel = mount.xyz[2] / float(np.sqrt(camera.fx * camera.fy))
    directions = np.ascontiguousarray(rays[below] @ mount.rotation.T)
    sigmas, diameters = (metres_per_pixel * pixels[below] for pixels in (dots.sigmas, dots.diameters))
    return SurveyImage(name, T_odom_base, directions, np.ascontiguousarray(points[below]), sigmas, diameters)


@dataclass(frozen=True)
class ViewOutline:
    """Outline of the view on the floor of the level robot: corners in the base frame, in order, (4, 2) [m]."""

    corners: Floats

    @property
    def width(self) -> float:
        """Side length of a square with the area of the view [m]."""
        x, y = self.corners.T
        return float(np.sqrt(0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))))

    @property
    def centre(self) -> Floats:
        """Centre of the view, shape (2,) [m]."""
        return self.corners.mean(axis=0)

    @property
    def radius(self) -> float:
        """Distance of the farthest corner from the centre [m]."""
        return float(np.hypot(*(self.corners - self.centre).T).max())

    def centres(self, states: Floats) -> Floats:
        """Return the centres of the views in the map frame, shape (k, 2) [m], of image states, shape (k, 6)."""
        (x, y), cos, sin = self.centre, np.cos(states[:, 2]), np.sin(states[:, 2])
        return np.asarray(states[:, :2] + np.column_stack([cos * x - sin * y, sin * x + cos * y]))

    def contains(self, points: Floats, margin: float) -> Booleans:
        """Return whether each point of the base frame, shape (n, 2), is in the view inside a margin [m]."""
        inside = np.ones(len(points), dtype=np.bool_)
        centre = self.centre
        for start, end in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            normal = np.array([start[1] - end[1], end[0] - start[0]]) / np.hypot(*(end - start))
            if normal @ (centre - start) < 0.0:
                normal = -normal
            inside &= (points - start) @ normal > margin
        return inside


def view_outline(camera: PinholeCamera, mount: CameraMount) -> ViewOutline:
    """Return a camera's view on the floor; raise a FloorLocalizerError if it sees the horizon."""
    right, lower = camera.width - 1.0, camera.height - 1.0
    pixels = np.array([[0.0, 0.0], [right, 0.0], [right, lower], [0.0, lower]])
    corners = mount.floor_points_from_rays(camera.rays_from_pixels(pixels))
    if not np.isfinite(corners).all():
        raise FloorLocalizerError(
            'camera_rpy: the camera sees the horizon, or its lens model is not valid at the corners of the image; '
            'a survey needs one that looks down'
        )
    return ViewOutline(corners)
