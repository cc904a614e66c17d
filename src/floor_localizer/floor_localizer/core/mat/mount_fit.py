"""Pose of the camera over a mat by least squares on the reprojection errors of its dots.

With the mat's dots m_i (z = 0), the camera's rotation R and position c in the mat frame and its projection project(),

    u_i = project(R^T (m_i - c)) + noise,

the six unknowns of R and c, and the focal length if it is unknown, minimise the reprojection errors with a robust
loss. For a camera that looks straight down, only the ratio of height and focal length, the pixel scale, is
observable. Then the height must be given with its accuracy, or the tilt must be large.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.dots import DetectedDots, DotMap
from shirube_core.geometry import PinholeCamera

_INLIER_GATE = 3.5
_ROUNDS = 3


@dataclass(frozen=True)
class MountFit:
    """Fitted pose of the camera over a mat.

    Attributes:
        camera: intrinsics with the fitted or given focal length.
        rotation: rotation matrix ``R_mat_camera``, shape (3, 3).
        position: optical centre in the mat frame, shape (3,) [m].
        covariance: covariance of the small rotations about the mat's axes [rad], the position [m] and the logarithm of
            the focal length, shape (7, 7); the last is 0 if it was given.
        residual: rms reprojection error [px].
        inliers: indices of the inlier dots of the image.
        dots: number of inliers.
    """

    camera: PinholeCamera
    rotation: Floats
    position: Floats
    covariance: Floats
    residual: float
    inliers: Ints

    @property
    def dots(self) -> int:
        """Number of inliers."""
        return len(self.inliers)


@dataclass(frozen=True)
class KnownHeight:
    """Measured camera height and its standard deviation [m]."""

    height: float
    sigma: float


def fit_mount(
    dots: DetectedDots,
    mat: DotMap,
    matches: tuple[Ints, Ints],
    camera: PinholeCamera,
    *,
    fit_focal_length: bool,
    known_height: KnownHeight | None = None,
) -> MountFit:
    """Fit the camera's pose to matched dots (indices in the image and in the mat) and reject outliers.

    The focal length of the camera is an initial one if it is fitted.
    """
    image_indices, mat_indices = matches
    state = _initial_guess(camera, dots.pixels[image_indices], mat.points[mat_indices])
    for _ in range(_ROUNDS):
        problem = _ReprojectionProblem(
            camera, dots.pixels[image_indices], dots.sigmas[image_indices], mat.points[mat_indices],
            fit_focal_length, known_height, state[0],
        )  # fmt: skip
        fit = least_squares(
            problem.residuals,
            np.concatenate([np.zeros(3), state[1], [state[2]]]),
            x_scale=problem.scales,
            loss='soft_l1',
            f_scale=3.0,
        )
        state = problem.state(fit.x)
        errors = np.linalg.norm(problem.pixel_errors(fit.x), axis=1)
        spread = max(float(np.median(errors)), 0.02)
        is_inlier = errors < _INLIER_GATE * spread * 1.5
        if is_inlier.all():
            break
        image_indices, mat_indices = image_indices[is_inlier], mat_indices[is_inlier]
    rotation, position, log_focal = state
    residual = float(np.sqrt(np.mean(np.sum(problem.pixel_errors(fit.x) ** 2, axis=1))))
    covariance = _covariance(np.asarray(fit.jac), fit.fun, fit_focal_length)
    scale = math.exp(log_focal)
    fitted = replace(camera, fx=scale * camera.fx, fy=scale * camera.fy)
    return MountFit(fitted, rotation, position, covariance, residual, image_indices)


def _covariance(jacobian: Floats, residuals: Floats, fit_focal_length: bool) -> Floats:
    """Return the inverse normal matrix, scaled by the reduced chi-square if that is above 1."""
    unknowns = 7 if fit_focal_length else 6
    normal = jacobian[:, :unknowns].T @ jacobian[:, :unknowns]
    degrees_of_freedom = max(len(residuals) - 7, 1)
    variance_factor = max(float(np.sum(residuals**2)) / degrees_of_freedom, 1.0)
    covariance = np.zeros((7, 7))
    try:
        covariance[:unknowns, :unknowns] = variance_factor * np.linalg.inv(normal)
    except np.linalg.LinAlgError:
        covariance[:] = np.inf
    if (covariance.diagonal()[:unknowns] <= 0.0).any():  # singular but for rounding
        covariance[:] = np.inf
    return covariance


def _initial_guess(camera: PinholeCamera, pixels: Floats, points: Floats) -> tuple[Floats, Floats, float]:
    """Return initial rotation and position from the homography of the dots, and 0 as the log focal length change."""
    rays = camera.rays_from_pixels(pixels)
    centroid = points.mean(axis=0)
    rows = []
    for (u, v, _), (x, y) in zip(rays, points - centroid, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y, -u], [0, 0, 0, x, y, 1, -v * x, -v * y, -v]]
    columns = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    columns *= np.sign(columns[2, 2]) / math.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    raw = np.column_stack([columns[:, 0], columns[:, 1], np.cross(columns[:, 0], columns[:, 1])])
    u, _, v = np.linalg.svd(raw)
    R_camera_mat = u @ v
    position = -R_camera_mat.T @ columns[:, 2] + (*centroid, 0.0)
    return R_camera_mat.T, position, 0.0


_NOT_IN_VIEW = 1e3  # error of a dot without a pixel [px]


@dataclass(frozen=True)
class _ReprojectionProblem:
    camera: PinholeCamera
    pixels: Floats
    sigmas: Floats
    points: Floats
    fit_focal_length: bool
    known_height: KnownHeight | None
    R_start: Floats

    @property
    def scales(self) -> Floats:
        return np.array([0.01, 0.01, 0.01, 0.001, 0.001, 0.001, 0.01])

    def state(self, x: Floats) -> tuple[Floats, Floats, float]:
        return Rotation.from_rotvec(x[:3]).as_matrix() @ self.R_start, x[3:6], float(x[6])

    def pixel_errors(self, x: Floats) -> Floats:
        rotation, position, log_focal = self.state(x)
        points = (np.column_stack([self.points, np.zeros(len(self.points))]) - position) @ rotation
        scale = math.exp(log_focal) if self.fit_focal_length else 1.0
        camera = replace(self.camera, fx=scale * self.camera.fx, fy=scale * self.camera.fy)
        # A trial step may move a dot out of the range of the lens model.
        return np.nan_to_num(camera.pixels_from_points(points) - self.pixels, nan=_NOT_IN_VIEW)

    def residuals(self, x: Floats) -> Floats:
        parts = [(self.pixel_errors(x) / self.sigmas[:, None]).ravel()]
        if self.known_height is not None:
            parts.append(np.array([(x[5] - self.known_height.height) / self.known_height.sigma]))
        return np.concatenate(parts)
