"""Lens models of OpenCV: from the ideal image plane z = 1 to the distorted one and back, within their valid range.

A polynomial is fitted to the image of the calibration. Beyond the radius at which it stops growing it folds back, so
that two rays have the same pixel: there, both directions return NaN instead of a wrong point.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Protocol

import cv2
import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from shirube_core.geometry.poses import matrix_from_rpy

Floats = NDArray[np.float64]

_UNDISTORT_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)
# OpenCV 4 takes the termination criteria in undistortPointsIter, OpenCV 5 in undistortPoints.
_HAS_UNDISTORT_ITER = hasattr(cv2, 'undistortPointsIter')
_ANGLE_MAX = math.radians(89.0)  # rays are scaled to z = 1, so they must be in front of the camera
_TABLE_SIZE = 512
_NEWTON_STEPS = 15
_RESIDUAL_MAX = 1e-9  # of the distorted point, in focal lengths


class LensModel(StrEnum):
    """Distortion models of ``sensor_msgs/CameraInfo``, which are OpenCV's."""

    PLUMB_BOB = 'plumb_bob'
    RATIONAL_POLYNOMIAL = 'rational_polynomial'
    EQUIDISTANT = 'equidistant'

    @property
    def counts(self) -> tuple[int, ...]:
        """Valid numbers of coefficients, of which the last is the largest."""
        match self:
            case LensModel.PLUMB_BOB:
                return (0, 4, 5)
            case LensModel.RATIONAL_POLYNOMIAL:
                return (8, 12, 14)
            case LensModel.EQUIDISTANT:
                return (4,)


class Lens(Protocol):
    """A lens with distortion; points are in focal lengths, relative to the principal point."""

    @property
    def radius_max(self) -> float:
        """Largest valid distance from the optical axis on the ideal image plane; at least 1 degree from z = 0."""

    def distort(self, points: Floats) -> Floats:
        """Return the distorted points, shape (n, 2), of points in front of the camera, shape (n, 3)."""

    def undistort(self, distorted: Floats) -> Floats:
        """Return the ideal points, shape (n, 2), of distorted ones, shape (n, 2), NaN beyond the valid range."""


def lens_of(model: LensModel, coefficients: tuple[float, ...]) -> Lens:
    """Return the lens of a model with its coefficients in OpenCV's order."""
    if model is LensModel.EQUIDISTANT:
        return EquidistantLens(coefficients)
    return PolynomialLens(coefficients)


@dataclass(frozen=True)
class PolynomialLens:
    """A lens of ``plumb_bob`` or ``rational_polynomial``.

    Attributes:
        coefficients: (k1, k2, p1, p2[, k3[, k4, k5, k6[, s1, s2, s3, s4[, tau_x, tau_y]]]]), of which s are the thin
            prism's and tau the sensor's tilt.
    """

    coefficients: tuple[float, ...]

    @cached_property
    def radius_max(self) -> float:
        """As in `Lens`: the first turning point or pole of the radial part r N(r^2) / D(r^2)."""
        k1, k2, _, _, k3, k4, k5, k6 = self._padded[:8]
        # s = r^2; d/dr (r N / D) is zero where (N + 2 s N') D - 2 s N D' is.
        s, N, D = Polynomial([0.0, 1.0]), Polynomial([1.0, k1, k2, k3]), Polynomial([1.0, k4, k5, k6])
        slope = (N + 2.0 * s * N.deriv()) * D - 2.0 * s * N * D.deriv()
        roots = np.concatenate([slope.trim().roots(), D.trim().roots()])
        real = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)].real
        return min(math.sqrt(min(real, default=math.inf)), math.tan(_ANGLE_MAX))

    def distort(self, points: Floats) -> Floats:
        """As in `Lens`; cv2.projectPoints would also fill a Jacobian of 24 columns, too large for whole images."""
        x, y = (points[:, :2] / points[:, 2:]).T
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = self._padded[:12]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        if k4 or k5 or k6:
            radial /= 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
        x, y = (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + s2 * r2),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + s4 * r2),
        )
        if self._tilt is None:
            return np.column_stack([x, y])
        tilted = np.column_stack([x, y, np.ones(len(x))]) @ self._tilt.T
        return np.asarray(tilted[:, :2] / tilted[:, 2:])

    @cached_property
    def _padded(self) -> tuple[float, ...]:
        return (*self.coefficients, *(0.0,) * 14)[:14]

    @cached_property
    def _tilt(self) -> Floats | None:
        """Homography of the tilted sensor, shape (3, 3), None if it is parallel."""
        tau_x, tau_y = self._padded[12:]
        if tau_x == tau_y == 0.0:
            return None
        R = matrix_from_rpy((-tau_x, -tau_y, 0.0))
        return np.asarray(np.array([[R[2, 2], 0.0, -R[0, 2]], [0.0, R[2, 2], -R[1, 2]], [0.0, 0.0, 1.0]]) @ R)

    def undistort(self, distorted: Floats) -> Floats:
        """As in `Lens`: OpenCV's iteration, and Newton's method for the points where that does not converge."""
        if len(distorted) == 0:
            return np.empty((0, 2))
        ideal = self._fixed_point(distorted)
        failed = np.flatnonzero(~self._is_solution(ideal, distorted))
        if len(failed):
            solved = self._newton(distorted[failed])
            solved[~self._is_solution(solved, distorted[failed])] = np.nan
            ideal[failed] = solved
        return ideal

    def _is_solution(self, ideal: Floats, distorted: Floats) -> NDArray[np.bool_]:
        residual = np.abs(self.distort(_homogeneous(ideal)) - distorted).max(axis=1)
        radius = np.hypot(*ideal.T)
        return np.asarray((residual < _RESIDUAL_MAX * (1.0 + radius)) & (radius <= self.radius_max))

    def _fixed_point(self, distorted: Floats) -> Floats:
        points, K, D = distorted.reshape(-1, 1, 2), np.eye(3), np.array(self.coefficients)
        if _HAS_UNDISTORT_ITER:
            ideal = cv2.undistortPointsIter(points, K, D, K, K, _UNDISTORT_CRITERIA)  # type: ignore[attr-defined]
        else:
            ideal = cv2.undistortPoints(points, K, D, criteria=_UNDISTORT_CRITERIA)
        return np.array(ideal, dtype=np.float64).reshape(-1, 2)

    def _newton(self, distorted: Floats) -> Floats:
        """Solve from the radial part's inverse, with difference quotients."""
        radii = np.tan(np.linspace(0.0, math.atan(self.radius_max), _TABLE_SIZE))
        images = np.hypot(*self.distort(np.column_stack([radii, 0.0 * radii, 0.0 * radii + 1.0])).T)
        length = np.maximum(np.hypot(*distorted.T), 1e-12)
        ideal = distorted * (np.interp(length, images, radii) / length)[:, None]
        for _ in range(_NEWTON_STEPS):
            step = 1e-7 * (1.0 + np.hypot(*ideal.T))[:, None]
            here = self.distort(_homogeneous(ideal))
            along_x = (self.distort(_homogeneous(ideal + step * (1.0, 0.0))) - here) / step
            along_y = (self.distort(_homogeneous(ideal + step * (0.0, 1.0))) - here) / step
            error = distorted - here
            determinant = along_x[:, 0] * along_y[:, 1] - along_x[:, 1] * along_y[:, 0]
            with np.errstate(divide='ignore', invalid='ignore'):
                change_x = (error[:, 0] * along_y[:, 1] - error[:, 1] * along_y[:, 0]) / determinant
                change_y = (along_x[:, 0] * error[:, 1] - along_x[:, 1] * error[:, 0]) / determinant
            change = np.nan_to_num(np.column_stack([change_x, change_y]), nan=0.0, posinf=0.0, neginf=0.0)
            # A step out of the valid range would find the root of the other branch.
            moved = ideal + change
            shrink = np.minimum(1.0, self.radius_max / np.maximum(np.hypot(*moved.T), 1e-12))
            ideal = moved * shrink[:, None]
        return np.asarray(ideal)


@dataclass(frozen=True)
class EquidistantLens:
    """A fisheye lens: theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).

    Attributes:
        coefficients: (k1, k2, k3, k4).
    """

    coefficients: tuple[float, ...]

    @cached_property
    def _image_angle(self) -> Polynomial:
        k1, k2, k3, k4 = self.coefficients
        return Polynomial([0.0, 1.0, 0.0, k1, 0.0, k2, 0.0, k3, 0.0, k4])

    @cached_property
    def _angle_max(self) -> float:
        """Angle of the first turning point [rad], at most 89 degrees."""
        roots = self._image_angle.deriv().trim().roots()
        real = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)].real
        return min(min(real, default=math.inf), _ANGLE_MAX)

    @property
    def radius_max(self) -> float:
        """As in `Lens`."""
        return math.tan(self._angle_max)

    def distort(self, points: Floats) -> Floats:
        """As in `Lens`."""
        radius = np.hypot(points[:, 0], points[:, 1])
        image = self._image_angle(np.arctan2(radius, points[:, 2]))
        # In the middle, theta_d / radius is 1 / z.
        scale = np.divide(image, radius, out=1.0 / points[:, 2], where=radius > 1e-9 * points[:, 2])
        return np.asarray(points[:, :2] * scale[:, None])

    def undistort(self, distorted: Floats) -> Floats:
        """As in `Lens`, by Newton's method within the range where theta_d grows."""
        image = np.hypot(distorted[:, 0], distorted[:, 1])
        angles = np.linspace(0.0, self._angle_max, _TABLE_SIZE)
        angle = np.interp(image, self._image_angle(angles), angles)
        slope = self._image_angle.deriv()
        for _ in range(_NEWTON_STEPS):
            with np.errstate(divide='ignore', invalid='ignore'):
                change = np.nan_to_num((image - self._image_angle(angle)) / slope(angle))
            angle = np.clip(angle + change, 0.0, self._angle_max)
        is_valid = np.abs(self._image_angle(angle) - image) < _RESIDUAL_MAX
        scale = np.divide(np.tan(angle), image, out=np.ones_like(image), where=image > 1e-9)
        return np.asarray(np.where(is_valid[:, None], distorted * scale[:, None], np.nan))


def _homogeneous(points: Floats) -> Floats:
    return np.column_stack([points, np.ones(len(points))])
