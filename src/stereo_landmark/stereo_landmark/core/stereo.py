"""A rectified stereo camera on a robot: its images, point measurements and their triangulation (paper 3.4)."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shirube_core.geometry import SE3, CameraMount, PinholeCamera, gravity_aligned_camera
from stereo_landmark.core.arrays import Floats, GreyImage, Masks
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

MEASUREMENT_SIZE = 4
"""Number of measured coordinates of a point: u, v in the left and u, v in the right image."""

INTRINSICS = ('width', 'height', 'fx', 'fy', 'cx', 'cy')
"""Intrinsics of a rectified camera that enter the calibration hash."""


@dataclass(frozen=True)
class StereoRig:
    """Rectified stereo cameras: rows are the same in both, and the right camera is at +x of the left one.

    Attributes:
        left: intrinsics of the left camera after rectification, without distortion.
        right: intrinsics of the right camera after rectification.
        baseline: distance between the cameras [m].
        mount: extrinsics of the left camera's optical frame on the robot.

    Raises:
        StereoLandmarkError: the baseline is not positive, or the cameras do not belong together.
    """

    left: PinholeCamera
    right: PinholeCamera
    baseline: float
    mount: CameraMount

    def __post_init__(self) -> None:
        if not (math.isfinite(self.baseline) and self.baseline > 0.0):
            raise StereoLandmarkError(
                f'baseline is {self.baseline:g} m, it must be positive; '
                "the right camera's projection_matrix holds -fx * baseline at [0, 3]: are left and right swapped?"
            )
        for name in ('fx', 'fy', 'cy', 'width', 'height'):
            left_value, right_value = getattr(self.left, name), getattr(self.right, name)
            if not math.isclose(left_value, right_value, rel_tol=1e-6):
                raise StereoLandmarkError(
                    f'{name} is {left_value:g} in the left and {right_value:g} in the right camera; '
                    'rectified cameras share it: calibrate them as a pair'
                )

    def project(self, points: Floats) -> Floats:
        """Project points, shape (n, 4): u, v left and u, v right [px].

        Args:
            points: points in the left optical frame, in front of the cameras, shape (n, 3) [m].
        """
        x, y, z = points.T
        v = self.left.fy * y / z + self.left.cy
        u_left = self.left.fx * x / z + self.left.cx
        u_right = self.right.fx * (x - self.baseline) / z + self.right.cx
        return np.column_stack([u_left, v, u_right, v])

    def jacobians(self, points: Floats) -> Floats:
        """Return the derivatives of `project` by the points, shape (n, 4, 3) [px/m]."""
        x, y, z = points.T
        zero = np.zeros_like(z)
        along_v = [zero, self.left.fy / z, -self.left.fy * y / z**2]
        along_left = [self.left.fx / z, zero, -self.left.fx * x / z**2]
        along_right = [self.right.fx / z, zero, -self.right.fx * (x - self.baseline) / z**2]
        rows = np.array([along_left, along_v, along_right, along_v])
        return np.ascontiguousarray(rows.transpose(2, 0, 1))

    def disparities(self, pixels: Floats) -> Floats:
        """Return the disparities of u, v left and u, v right, shape (..., 4), 0 at infinity, shape (...) [px]."""
        return np.asarray((pixels[..., 0] - self.left.cx) - (pixels[..., 2] - self.right.cx))

    def back_project(self, pixels: Floats) -> Floats:
        """Return the points at u, v left and u, v right, shape (n, 4) [px], in the left optical frame, (n, 3) [m]."""
        left = self.left
        z = left.fx * self.baseline / self.disparities(pixels)
        x = (pixels[:, 0] - left.cx) / left.fx * z
        y = (0.5 * (pixels[:, 1] + pixels[:, 3]) - left.cy) / left.fy * z
        return np.column_stack([x, y, z])


def calibration_hash(rig: StereoRig) -> str:
    """Return a hash of the rectified intrinsics and the baseline, rounded to nine digits."""
    numbers = [getattr(camera, name) for camera in (rig.left, rig.right) for name in INTRINSICS]
    text = ' '.join(f'{number:.9g}' for number in (*numbers, rig.baseline))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True, eq=False)
class StereoImages:
    """A stereo pair.

    Attributes:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
        tilt: roll and pitch of the base at the stamp of the images [rad].
    """

    left: GreyImage
    right: GreyImage
    tilt: tuple[float, float] = (0.0, 0.0)


DISPARITY_MIN = 0.5
"""Minimum disparity; a point below it is too far away, or a wrong match [px]."""
ROW_GATE_SIGMAS, ROW_TOLERANCE = 5.0, 0.3
"""Largest row difference of a point [standard deviations], or, as calibrations have it, [px]."""
ITERATIONS = 3


@dataclass(frozen=True)
class StereoPoints:
    """Named points in a rectified stereo pair.

    Attributes:
        names: n unique names.
        pixels: u, v in the left and u, v in the right image, shape (n, 4) [px].
        covariances: covariances of the pixels, shape (n, 4, 4) [px²].
    """

    names: tuple[str, ...]
    pixels: Floats
    covariances: Floats

    def __len__(self) -> int:
        return len(self.names)

    def subset(self, kept: Masks) -> StereoPoints:
        """Return the points selected by a mask, shape (n,)."""
        names = tuple(name for name, is_kept in zip(self.names, kept, strict=True) if is_kept)
        return StereoPoints(names, self.pixels[kept], self.covariances[kept])


@dataclass(frozen=True)
class SpatialPoints:
    """Named 3D points.

    Attributes:
        names: n unique names.
        positions: coordinates, shape (n, 3) [m].
        covariances: covariances of the coordinates, shape (n, 3, 3) [m²].
    """

    names: tuple[str, ...]
    positions: Floats
    covariances: Floats

    def __len__(self) -> int:
        return len(self.names)

    def select(self, names: tuple[str, ...]) -> SpatialPoints:
        """Return the points with these names, in their order; all must exist."""
        index = [self.names.index(name) for name in names]
        return SpatialPoints(names, self.positions[index], self.covariances[index])

    def transform(self, rotation: Floats, shift: Floats) -> SpatialPoints:
        """Transform the points into another frame: rotation, shape (3, 3), then translation, shape (3,) [m]."""
        positions = self.positions @ rotation.T + shift
        return SpatialPoints(self.names, positions, rotation @ self.covariances @ rotation.T)


def concatenate(groups: Sequence[StereoPoints]) -> StereoPoints:
    """Concatenate sets of points."""
    return StereoPoints(
        tuple(name for group in groups for name in group.names),
        np.concatenate([np.empty((0, MEASUREMENT_SIZE)), *(group.pixels for group in groups)]),
        np.concatenate([np.empty((0, MEASUREMENT_SIZE, MEASUREMENT_SIZE)), *(group.covariances for group in groups)]),
    )


def is_measurable(points: StereoPoints, rig: StereoRig) -> Masks:
    """Return the mask of points with enough disparity to be triangulated, shape (n,)."""
    return rig.disparities(points.pixels) >= DISPARITY_MIN


def is_in_same_row(points: StereoPoints, pixel_sigma: float) -> Masks:
    """Return the mask of points that satisfy the epipolar constraint (same row in both images), shape (n,).

    Args:
        points: n points.
        pixel_sigma: calibration error along each axis of each image [px].
    """
    variances = points.covariances[:, 1, 1] + points.covariances[:, 3, 3] - 2.0 * points.covariances[:, 1, 3]
    row_difference = np.abs(points.pixels[:, 1] - points.pixels[:, 3])
    gate = ROW_GATE_SIGMAS * np.sqrt(variances + 2.0 * pixel_sigma**2)
    return np.asarray(row_difference <= np.maximum(gate, ROW_TOLERANCE))


def add_calibration_noise(points: StereoPoints, pixel_sigma: float) -> StereoPoints:
    """Return points with the calibration error [px] added to their covariances.

    Without it the depths of near points would be too certain, and the fit would rotate about the target.
    """
    return StereoPoints(points.names, points.pixels, points.covariances + pixel_sigma**2 * np.eye(MEASUREMENT_SIZE))


def triangulate(points: StereoPoints, rig: StereoRig) -> SpatialPoints:
    """Triangulate measurable points into the left optical frame, with covariances propagated from the pixel noise."""
    positions = rig.back_project(points.pixels)
    weights = np.linalg.inv(points.covariances)
    for _ in range(ITERATIONS):
        jacobians = rig.jacobians(positions)
        information = jacobians.transpose(0, 2, 1) @ weights @ jacobians
        gradients = jacobians.transpose(0, 2, 1) @ weights @ (points.pixels - rig.project(positions))[:, :, None]
        positions = positions + np.linalg.solve(information, gradients)[:, :, 0]
    return SpatialPoints(points.names, positions, np.asarray(np.linalg.inv(information)))


class CameraView:
    """The cameras at a tilt of the base, which predictions and points in space need.

    Attributes:
        rig: stereo cameras.
        tilt: roll and pitch of the base [rad].
    """

    rig: StereoRig
    tilt: tuple[float, float]

    @cached_property
    def camera(self) -> SE3:
        """Left camera in the gravity-aligned base frame."""
        return gravity_aligned_camera(self.rig.mount, *self.tilt)

    def spatial_points(self, points: StereoPoints) -> SpatialPoints:
        """Triangulate points into the gravity-aligned base frame."""
        return triangulate(points, self.rig).transform(self.camera.rotation, self.camera.position)


@dataclass(frozen=True)
class TiltedCameras(CameraView):
    """The cameras of a pair whose images are not needed."""

    rig: StereoRig
    tilt: tuple[float, float] = (0.0, 0.0)
