"""Fits one pose to the points of shapes and features: reprojection in both images with shared systematic errors.

The state is that of `fit_reprojection`, followed by the systematic errors all points of a pair share: disparity and
row difference now, and the disparity at teaching. They have priors, so that the covariance of the pose contains them.
Shapes and features are two groups of points. The noise of each group is estimated from its own residuals, so that each
has the weight that it deserves in these images. A Cauchy loss bounds the influence of outliers.
"""

import math
from dataclasses import dataclass

import numpy as np

from shirube_core.geometry import covariance_from_information, matrix_from_rpy, wrap_angle
from stereo_landmark.core.arrays import Floats, Masks
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, SpatialPoints, StereoPoints, StereoRig

STATE_SIZE = 6
ROLL, PITCH = 4, 5
DEPTH_MIN = 0.05
"""Nearer points are not visible [m]."""


@dataclass(frozen=True)
class Reprojection:
    """Predicted pixels of taught points, with Jacobians.

    Attributes:
        pixels: predicted u, v left and u, v right, shape (n, 4) [px].
        state_jacobian: Jacobians of the pixels by the state, shape (n, 4, 6).
        point_jacobian: Jacobians of the pixels by the taught points, shape (n, 4, 3) [px/m].
        in_front: mask of the points in front of the cameras, shape (n,).
    """

    pixels: Floats
    state_jacobian: Floats
    point_jacobian: Floats
    in_front: Masks


def reproject(state: Floats, taught: Floats, rig: StereoRig) -> Reprojection:
    """Project taught points into both cameras.

    Args:
        state: state of the robot, shape (6,).
        taught: taught points in the place's frame, shape (n, 3) [m].
        rig: stereo cameras.
    """
    R_place_level = matrix_from_rpy((0.0, 0.0, state[3]))
    R_level_base = matrix_from_rpy((state[ROLL], state[PITCH], 0.0))
    R_place_base = R_place_level @ R_level_base
    base = (taught - state[:3]) @ R_place_base
    optical = (base - np.array(rig.mount.xyz)) @ rig.mount.rotation
    in_front = optical[:, 2] > DEPTH_MIN
    safe = np.where(in_front[:, None], optical, [0.0, 0.0, 1.0])
    pixel_jacobian = rig.jacobians(safe)
    R_optical_base = rig.mount.rotation.T
    base_jacobian = np.zeros((len(taught), 3, STATE_SIZE))
    base_jacobian[:, :, :3] = -R_place_base.T
    level = (taught - state[:3]) @ R_place_level
    base_jacobian[:, :, 3] = np.column_stack([level[:, 1], -level[:, 0], np.zeros(len(level))]) @ R_level_base
    base_jacobian[:, :, ROLL] = np.cross(base, [1.0, 0.0, 0.0])
    base_jacobian[:, :, PITCH] = np.cross(base, [0.0, math.cos(state[ROLL]), -math.sin(state[ROLL])])
    return Reprojection(
        rig.project(safe),
        pixel_jacobian @ R_optical_base @ base_jacobian,
        pixel_jacobian @ (R_place_base @ rig.mount.rotation).T,
        in_front,
    )


ITERATIONS_MAX = 20
STEP_TOLERANCE = 1e-7
"""Convergence: the iteration stops when the step is smaller than this [m, rad]."""
HUBER_THRESHOLD = 3.0
"""Threshold of the Huber loss [standard deviations]; four normal residuals have a norm of at most 3.1 in 95 %."""
DETERMINANT_MIN = 1e-12
"""Minimum determinant of the information matrix, normalized to a unit diagonal, for an observable state."""


@dataclass(frozen=True)
class ReprojectionFit:
    """An estimated state.

    Attributes:
        state: estimated state, shape (6,).
        covariance: state covariance, shape (6, 6), zero for fixed states.
        residuals: reprojection residuals, shape (n, 4) [px].
        mahalanobis_distances: Mahalanobis distances of the residuals, shape (n,); infinite behind the cameras.
    """

    state: Floats
    covariance: Floats
    residuals: Floats
    mahalanobis_distances: Floats


def fit_reprojection(
    observed: StereoPoints, taught: SpatialPoints, rig: StereoRig, start: Floats, settings: PlaceSettings
) -> ReprojectionFit | None:
    """Fit the state by iteratively reweighted Gauss-Newton steps.

    Args:
        observed: n measured points.
        taught: the same points in the same order, in the place's frame.
        rig: stereo cameras.
        start: initial state, shape (6,); its roll and pitch are the prior.
        settings: standard deviations of the calibration and of the tilt prior.

    Returns:
        estimated state, or None where the points do not determine it.
    """
    free = np.arange(STATE_SIZE) if settings.tilt_sigma > 0.0 else np.arange(ROLL)
    prior = np.zeros((STATE_SIZE, STATE_SIZE))
    if settings.tilt_sigma > 0.0:
        prior[[ROLL, PITCH], [ROLL, PITCH]] = settings.tilt_sigma**-2
    noise = observed.covariances + settings.pixel_sigma**2 * np.eye(MEASUREMENT_SIZE)
    state = start.copy()
    for _ in range(ITERATIONS_MAX):
        residuals, jacobian, mahalanobis_distances = _whiten(observed, taught, rig, state, noise)
        weights = np.where(
            np.isfinite(mahalanobis_distances),
            np.minimum(1.0, HUBER_THRESHOLD / np.maximum(mahalanobis_distances, 1e-9)),
            0.0,
        )
        weighted = jacobian * weights[:, None, None]
        information = np.einsum('nij,nik->jk', weighted, jacobian) + prior
        gradient = np.einsum('nij,ni->j', weighted, residuals) + prior @ (start - state)
        inverse = covariance_from_information(information[np.ix_(free, free)], DETERMINANT_MIN)
        if inverse is None:
            return None
        step = np.zeros(STATE_SIZE)
        step[free] = inverse @ gradient[free]
        state = state + step
        if np.abs(step).max() < STEP_TOLERANCE:
            break
    state[3] = wrap_angle(float(state[3]))
    covariance = np.zeros((STATE_SIZE, STATE_SIZE))
    covariance[np.ix_(free, free)] = inverse
    view = reproject(state, taught.positions, rig)
    _, _, mahalanobis_distances = _whiten(observed, taught, rig, state, noise)
    return ReprojectionFit(state, covariance, observed.pixels - view.pixels, mahalanobis_distances)


def _whiten(
    observed: StereoPoints, taught: SpatialPoints, rig: StereoRig, state: Floats, noise: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return whitened residuals (n, 4), whitened Jacobians (n, 4, 6) and Mahalanobis distances (n,)."""
    view = reproject(state, taught.positions, rig)
    total_covariances = noise + view.point_jacobian @ taught.covariances @ view.point_jacobian.transpose(0, 2, 1)
    sqrt_information = np.linalg.inv(np.linalg.cholesky(total_covariances))
    residuals = (sqrt_information @ (observed.pixels - view.pixels)[:, :, None])[:, :, 0]
    mahalanobis_distances = np.where(view.in_front, np.linalg.norm(residuals, axis=1), np.inf)
    return residuals, sqrt_information @ view.state_jacobian, mahalanobis_distances


BIASES = 3

JOINT_ITERATIONS_MAX = 12
JOINT_STEP_TOLERANCE = 1e-5
"""Convergence: the iteration stops when the step is smaller than this [m, rad, px]."""
CAUCHY_THRESHOLD = 1.5
"""Scale of the Cauchy loss [standard deviations]."""
GATE = 8.0
"""Points farther away have no weight [standard deviations]."""
MEDIAN_SQUARE = 3.357
"""Median of the chi-square distribution of four degrees of freedom."""
GROUP_MIN = 8
"""Minimum number of points that determine the noise of their group."""
SCALES_MIN = 1.0, 0.2
"""Smallest ratio of the noise of features and shapes to the stated one; errors of near features are alike."""
FREE_TILT_SIGMA = 0.05
"""Prior of roll and pitch with features, which determine both [rad]."""


@dataclass(frozen=True)
class JointPoints:
    """Points of shapes and features.

    Attributes:
        pixels: u, v left and u, v right, shape (n, 4) [px].
        covariances: their covariances, shape (n, 4, 4) [px²].
        positions: taught points in the place's frame, shape (n, 3) [m].
        position_covariances: their covariances, shape (n, 3, 3) [m²].
        is_feature: mask of the features, shape (n,).
    """

    pixels: Floats
    covariances: Floats
    positions: Floats
    position_covariances: Floats
    is_feature: Masks


def fit_jointly(
    points: JointPoints,
    rig: StereoRig,
    start: Floats,
    tilt: tuple[float, float],
    settings: PlaceSettings,
    iterations: int = JOINT_ITERATIONS_MAX,
) -> ReprojectionFit | None:
    """Fit the pose; None where the points do not determine it.

    Args:
        points: points of shapes and features.
        rig: stereo cameras.
        start: initial state, shape (6,).
        tilt: known roll and pitch of the base [rad].
        settings: standard deviations of calibration, systematic errors and tilt.
        iterations: maximum number of steps.
    """
    prior_mean = np.concatenate([np.zeros(ROLL), tilt, np.zeros(BIASES)])
    prior = np.zeros(STATE_SIZE + BIASES)
    prior[[ROLL, PITCH]] = max(settings.tilt_sigma, FREE_TILT_SIGMA if settings.tilt_sigma > 0.0 else 1e-6) ** -2
    prior[STATE_SIZE:] = settings.bias_sigma**-2
    noise = points.covariances + settings.pixel_sigma**2 * np.eye(MEASUREMENT_SIZE)
    state, covariance = np.concatenate([start, np.zeros(BIASES)]), np.diag(prior)
    # The noise of the taught points in the images depends little on the state.
    view = reproject(start, points.positions, rig)
    spread = view.point_jacobian @ points.position_covariances @ view.point_jacobian.transpose(0, 2, 1)
    sqrt_information = np.linalg.inv(np.linalg.cholesky(noise + spread))
    for _ in range(iterations):
        residuals, jacobian, whitened = _linearize(points, rig, state, sqrt_information)
        scales = _noise_scales(whitened, points.is_feature)
        distances = np.linalg.norm(whitened, axis=1) / scales
        weights = np.where(distances < GATE, 1.0 / (1.0 + (distances / CAUCHY_THRESHOLD) ** 2), 0.0)
        weights /= scales**2
        columns = jacobian.reshape(-1, len(prior)).T
        weighted = columns * np.repeat(weights, MEASUREMENT_SIZE)
        information, gradient = weighted @ columns.T + np.diag(prior), weighted @ whitened.ravel()
        inverse = covariance_from_information(information, DETERMINANT_MIN)
        if inverse is None:
            return None
        covariance = inverse
        step = covariance @ (gradient + prior * (prior_mean - state))
        state = state + step
        if np.abs(step).max() < JOINT_STEP_TOLERANCE:
            break
    state[3] = wrap_angle(float(state[3]))
    pose = slice(0, STATE_SIZE)
    return ReprojectionFit(state[pose], covariance[pose, pose], residuals, distances)


def _noise_scales(whitened: Floats, is_feature: Masks) -> Floats:
    """Return the ratio of the noise of the group of each point to the stated one, shape (n,)."""
    squares = np.sum(whitened**2, axis=1)
    scales = np.ones(len(squares))
    for group, least in zip((is_feature, ~is_feature), SCALES_MIN, strict=True):
        if group.sum() >= GROUP_MIN:
            scales[group] = max(np.sqrt(np.median(squares[group]) / MEDIAN_SQUARE), least)
    return scales


def _linearize(
    points: JointPoints, rig: StereoRig, state: Floats, sqrt_information: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return residuals (n, 4), whitened Jacobians (n, 4, 9) and whitened residuals (n, 4)."""
    view = reproject(state[:STATE_SIZE], points.positions, rig)
    # A disparity error at teaching moves a point along its ray, the more the farther away it is.
    rays = points.positions - np.array(rig.mount.xyz)
    depths = rays @ rig.mount.rotation[:, 2]
    by_taught = -view.point_jacobian @ (rays * (depths / (rig.left.fx * rig.baseline))[:, None])[:, :, None]
    by_now = np.zeros((len(rays), MEASUREMENT_SIZE, 2))
    by_now[:, 2, 0], by_now[:, 3, 1] = 1.0, 1.0
    biases = np.concatenate([by_now, by_taught], axis=2)
    residuals = points.pixels - view.pixels - biases @ state[STATE_SIZE:]
    jacobian = sqrt_information @ np.concatenate([view.state_jacobian, biases], axis=2)
    whitened = (sqrt_information @ residuals[:, :, None])[:, :, 0]
    jacobian[~view.in_front], whitened[~view.in_front] = 0.0, np.inf
    return residuals, jacobian, np.where(np.isfinite(whitened), whitened, 1e6)
