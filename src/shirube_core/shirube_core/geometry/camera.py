"""A camera: intrinsics, extrinsics on the robot, projection to the floor, and pose on a robot with a buffered tilt.

The intrinsics are those of ``sensor_msgs/CameraInfo``: a pinhole with ``plumb_bob`` distortion.

Pixel coordinates have their origin in the centre of the upper left pixel, u to the right and v down.
Points and rays are in the camera's optical frame: x right, y down, z forward.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_core.geometry.poses import SE3, matrix_from_rpy

_UNDISTORT_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)
# OpenCV 4 takes the termination criteria in undistortPointsIter, OpenCV 5 in undistortPoints.
_HAS_UNDISTORT_ITER = hasattr(cv2, 'undistortPointsIter')


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of a camera.

    Attributes:
        width: image width [px].
        height: image height [px].
        fx: focal length along u [px].
        fy: focal length along v [px].
        cx: principal point, u [px].
        cy: principal point, v [px].
        distortion: plumb_bob coefficients (k1, k2, p1, p2, k3).
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Reject invalid intrinsics.

        Raises:
            ValueError: a size or focal length that is not positive, or a number that is not finite.
        """
        if self.width < 1 or self.height < 1:
            raise ValueError(f'the image size is {self.width} x {self.height}, it must be positive')
        numbers = (self.fx, self.fy, self.cx, self.cy, *self.distortion)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError('an intrinsic parameter is not finite')
        if self.fx <= 0.0 or self.fy <= 0.0:
            raise ValueError(f'the focal length is ({self.fx}, {self.fy}) px, it must be positive')

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix K, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def rays_from_pixels(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the undistorted rays through pixels.

        Args:
            pixels: array-like, shape (n, 2), u and v [px].

        Returns:
            array, shape (n, 3), directions in the optical frame, scaled to z = 1.
        """
        points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
        rays = np.ones((len(points), 3))
        if len(points) == 0:
            return rays
        if not any(self.distortion):
            rays[:, :2] = (points[:, 0] - (self.cx, self.cy)) / (self.fx, self.fy)
            return rays
        distortion = np.array(self.distortion)
        if _HAS_UNDISTORT_ITER:
            undistorted = cv2.undistortPointsIter(  # type: ignore[attr-defined]
                points, self.matrix, distortion, np.eye(3), np.eye(3), _UNDISTORT_CRITERIA
            )
        else:
            undistorted = cv2.undistortPoints(points, self.matrix, distortion, criteria=_UNDISTORT_CRITERIA)
        rays[:, :2] = undistorted[:, 0]
        return rays

    def pixels_from_points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Project points in front of the camera into the image, with distortion.

        Args:
            points: array-like, shape (n, 3), coordinates in the optical frame [m], z > 0.

        Returns:
            array, shape (n, 2), u and v [px].
        """
        objects = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 1, 3)
        if len(objects) == 0:
            return np.empty((0, 2))
        pixels, _ = cv2.projectPoints(
            objects, np.zeros(3), np.zeros(3), self.matrix, np.array(self.distortion)
        )
        return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)


@dataclass(frozen=True)
class CameraMount:
    """Pose of a camera's optical frame in ``base_link``, whose z = 0 plane is the floor.

    Attributes:
        xyz: position of the optical centre in the base frame [m].
        rpy: fixed-axis roll, pitch, yaw of the optical frame in the base frame [rad].
            ``(pi, 0, -pi/2)`` looks straight down; the upper edge of the image is at the front.
    """

    xyz: tuple[float, float, float] = (0.0, 0.0, 0.13)
    rpy: tuple[float, float, float] = (math.pi, 0.0, -math.pi / 2.0)

    @cached_property
    def rotation(self) -> NDArray[np.float64]:
        """``R_base_camera``, shape (3, 3), read-only."""
        rotation = matrix_from_rpy(self.rpy)
        rotation.flags.writeable = False
        return rotation

    def floor_points_from_rays(self, rays: ArrayLike) -> NDArray[np.float64]:
        """Intersect rays of the camera with the floor.

        Args:
            rays: array-like, shape (n, 3), directions in the optical frame.

        Returns:
            array, shape (n, 2), x and y in the base frame [m]; NaN for a ray that does not point down.
        """
        directions = np.asarray(rays, dtype=np.float64) @ self.rotation.T
        x, y, z = self.xyz
        with np.errstate(divide='ignore', invalid='ignore'):
            scale = np.where(directions[:, 2] < 0.0, -z / directions[:, 2], np.nan)
        return np.column_stack([x + scale * directions[:, 0], y + scale * directions[:, 1]])

    def camera_points_from_floor(self, points: ArrayLike) -> NDArray[np.float64]:
        """Transform floor points from the base frame to the optical frame.

        Args:
            points: array-like, shape (n, 2), x and y in the base frame [m], on the floor.

        Returns:
            array, shape (n, 3), in the optical frame [m].
        """
        floor = np.asarray(points, dtype=np.float64)
        base = np.column_stack([floor, np.zeros(len(floor))])
        return (base - np.array(self.xyz)) @ self.rotation


def gravity_aligned_camera(mount: CameraMount, roll: float = 0.0, pitch: float = 0.0) -> SE3:
    """Return the pose of a tilted robot's camera in the level frame: origin and yaw of the base, z against gravity.

    Args:
        mount: extrinsics of the camera on the robot.
        roll: roll of the base about its x axis [rad].
        pitch: pitch of the base about its y axis [rad]; positive with the nose down.
    """
    T_level_base = SE3.from_rpy((0.0, 0.0, 0.0), (roll, pitch, 0.0))
    return T_level_base @ SE3(mount.rotation, np.array(mount.xyz))


_READINGS_MAX = 2000
"""Buffer length: 10 s of a fast IMU, since images arrive later than their IMU readings."""
_TILT_AGE_MAX = 0.1
"""Largest difference between the stamps of a tilt and an image [s]; a robot sways faster than this."""


class TiltBuffer:
    """Recent roll and pitch of the base."""

    def __init__(self) -> None:
        """Start without readings."""
        self._readings: deque[tuple[float, tuple[float, float]]] = deque(maxlen=_READINGS_MAX)

    def add(self, stamp: float, roll: float, pitch: float) -> None:
        """Add fixed-axis roll and pitch of the base [rad] at a stamp [s]."""
        self._readings.append((stamp, (roll, pitch)))

    def tilt_at(self, stamp: float) -> tuple[float, float] | None:
        """Return the roll and pitch [rad] nearest to a stamp [s], None without a reading within 0.1 s."""
        if not self._readings:
            return None
        nearest, tilt = min(self._readings, key=lambda reading: abs(reading[0] - stamp))
        return tilt if abs(nearest - stamp) <= _TILT_AGE_MAX else None
