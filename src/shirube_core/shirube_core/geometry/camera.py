"""A camera: intrinsics, extrinsics on the robot, projection to the floor, and pose on a robot with a buffered tilt.

The intrinsics are those of ``sensor_msgs/CameraInfo``: a camera matrix and one of OpenCV's lens models.

Pixel coordinates have their origin in the centre of the upper left pixel, u to the right and v down.
Points and rays are in the camera's optical frame: x right, y down, z forward.
"""

import math
from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_core.geometry.lens import Lens, LensModel, lens_of
from shirube_core.geometry.poses import SE3, matrix_from_rpy


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
        distortion: coefficients of the lens model in OpenCV's order; (k1, k2, p1, p2, k3) for plumb_bob.
        model: lens model.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)
    model: LensModel = LensModel.PLUMB_BOB

    def __post_init__(self) -> None:
        """Reject invalid intrinsics.

        Raises:
            ValueError: a size or focal length that is not positive, a number that is not finite, or a number of
                coefficients that the lens model does not have.
        """
        if self.width < 1 or self.height < 1:
            raise ValueError(f'the image size is {self.width} x {self.height}, it must be positive')
        numbers = (self.fx, self.fy, self.cx, self.cy, *self.distortion)
        if not all(math.isfinite(number) for number in numbers):
            raise ValueError('an intrinsic parameter is not finite')
        if self.fx <= 0.0 or self.fy <= 0.0:
            raise ValueError(f'the focal length is ({self.fx}, {self.fy}) px, it must be positive')
        if len(self.distortion) not in self.model.counts:
            counts = ' or '.join(map(str, self.model.counts))
            raise ValueError(
                f'the distortion model {self.model.value!r} has {len(self.distortion)} numbers instead of {counts}'
            )

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix K, shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def has_distortion(self) -> bool:
        """Whether the image differs from that of a pinhole; an equidistant lens differs without coefficients, too."""
        return self.model is LensModel.EQUIDISTANT or any(self.distortion)

    @cached_property
    def _lens(self) -> Lens:
        return lens_of(self.model, self.distortion)

    def rays_from_pixels(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the undistorted rays through pixels.

        Args:
            pixels: array-like, shape (n, 2), u and v [px].

        Returns:
            array, shape (n, 3), directions in the optical frame, scaled to z = 1; x and y are NaN where the lens model
            is not valid.
        """
        points = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
        rays = np.ones((len(points), 3))
        distorted = (points - (self.cx, self.cy)) / (self.fx, self.fy)
        rays[:, :2] = self._lens.undistort(distorted) if self.has_distortion else distorted
        return rays

    def pixels_from_points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Project points into the image, with distortion.

        Args:
            points: array-like, shape (n, 3), coordinates in the optical frame [m].

        Returns:
            array, shape (n, 2), u and v [px]; NaN for points behind the camera or where the lens model is not valid.
        """
        objects = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        pixels = np.full((len(objects), 2), np.nan)
        is_valid = np.hypot(objects[:, 0], objects[:, 1]) <= self._lens.radius_max * objects[:, 2]
        is_valid &= objects[:, 2] > 0.0
        pixels[is_valid] = self._lens.distort(objects[is_valid]) * (self.fx, self.fy) + (self.cx, self.cy)
        return pixels

    def rectification_maps(
        self, rotation: NDArray[np.float64], matrix: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return u and v in this image for each pixel of a rectified image of the same size, for ``cv2.remap``.

        Beyond the valid range of the lens model they are those of the nearest valid ray.

        Args:
            rotation: rectification matrix R, from this camera's frame to the rectified frame, shape (3, 3).
            matrix: camera matrix of the rectified image, shape (3, 3).
        """
        v, u = np.mgrid[: self.height, : self.width].astype(np.float64)
        pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
        x, y, z = np.linalg.inv(matrix @ rotation) @ pixels
        x, y = x / np.maximum(z, 1e-9), y / np.maximum(z, 1e-9)
        inside = np.minimum((1.0 - 1e-9) * self._lens.radius_max / np.maximum(np.hypot(x, y), 1e-9), 1.0)
        found = self.pixels_from_points(np.column_stack([x * inside, y * inside, np.ones(len(x))])).astype(np.float32)
        return found[:, 0].reshape(u.shape), found[:, 1].reshape(u.shape)


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
