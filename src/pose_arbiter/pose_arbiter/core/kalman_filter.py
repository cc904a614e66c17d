"""Extended Kalman filter of the robot's pose and the biases of the sources: predict and update.

The state is the pose and three Gauss-Markov biases of each source: poses of one source are correlated, and a filter
that treated them as independent would follow the source with the highest rate. Where sources differ, their biases are
estimated and kept, so that the more accurate one still counts while only the other one publishes.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pose_arbiter.core.settings import ArbiterSettings
from shirube_core.geometry import SE2
from shirube_core.motion import CumulativeOdometry, motion_between, motion_covariance

_PROCESS_NOISE_XY, _PROCESS_NOISE_YAW = 2e-3, 2e-3  # process noise after 1 s, standard deviations [m, rad]
_SIGMA_ENTRIES = (2, 0, 1), (0, 1, 2)  # entries of `bias_sqrt`: yaw, then along and across
_EPSILON = 1e-12  # smallest divisor [m, rad]

Covariance = tuple[float, float, float, float, float, float]
"""Covariance of (x, y, yaw): six floats are many times faster than a 3 x 3 array.

The order is xx, xy, xt, yy, yt, tt, where t is yaw [m², m rad, rad²].
"""
Vector = tuple[float, float, float]


class Estimate(NamedTuple):
    """State estimate of the filter at one stamp.

    Attributes:
        odometry: cumulative odometry at that stamp.
        x, y, yaw: ``T_map_base`` [m, rad].
        bias: shape (s, 3), biases u of the s sources, in units of their standard deviations (`bias_sqrt`).
        bias_sigmas: shape (s, 3), those standard deviations at the latest pose of each source [rad, m, m].
        P: shape (3 + 3 s, 3 + 3 s), covariance of (x, y, yaw) [m, rad] and of the biases.
    """

    odometry: CumulativeOdometry
    x: float
    y: float
    yaw: float
    bias: NDArray[np.float64]
    bias_sigmas: NDArray[np.float64]
    P: NDArray[np.float64]

    @property
    def pose(self) -> SE2:
        """``T_map_base``."""
        return SE2(self.x, self.y, self.yaw)

    @property
    def covariance(self) -> Covariance:
        """Covariance of (x, y, yaw)."""
        (xx, xy, xt), (_, yy, yt), (_, _, tt) = self.P[:3, :3].tolist()
        return (xx, xy, xt, yy, yt, tt)


def initialize(odometry: CumulativeOdometry, pose: SE2, noise: Covariance, sources: int) -> Estimate:
    """Return the initial estimate from a prior pose and its covariance, for a number of sources."""
    P = np.eye(3 + 3 * sources)
    P[:3, :3] = as_matrix(noise)
    bias, bias_sigmas = np.zeros((sources, 3)), np.full((sources, 3), np.inf)
    return Estimate(odometry, pose.x, pose.y, pose.yaw, bias, bias_sigmas, P)


def initialize_from_source(begin: Estimate, source: int, noise: Covariance, bias_fraction: float) -> Estimate:
    """Return the initial estimate from a source's pose, correlated with the bias of that source.

    Args:
        begin: estimate from `initialize`, with a covariance not less than R.
        source: source index.
        noise: covariance R of the measurement.
        bias_fraction: fraction of R that is bias.
    """
    P, bias_sigmas = begin.P.copy(), begin.bias_sigmas.copy()
    columns, L = _bias_columns(source), bias_sqrt(noise)
    P[:3, columns] = -math.sqrt(bias_fraction) * L
    P[columns, :3] = P[:3, columns].T
    bias_sigmas[source] = L[_SIGMA_ENTRIES]
    return begin._replace(bias_sigmas=bias_sigmas, P=P)


def predict(estimate: Estimate, odometry: CumulativeOdometry, settings: ArbiterSettings) -> Estimate:
    """Time update: move the estimate by odometry, P ← F P Fᵀ + Q, and decay the biases."""
    motion = motion_between(estimate.odometry, odometry)
    yaw_offset = estimate.yaw - estimate.odometry.yaw  # rotation from the buffer frame to the map
    cos, sin = math.cos(yaw_offset), math.sin(yaw_offset)
    x, y = cos * motion.x - sin * motion.y, sin * motion.x + cos * motion.y
    odometry_noise = motion_covariance(
        estimate.odometry, odometry, settings.odometry_noise_xy, settings.odometry_noise_yaw
    )
    noise = add_covariances(
        rotate_covariance(odometry_noise, cos, sin),
        diagonal(
            (settings.drift_speed * motion.odometry_gap) ** 2 + _PROCESS_NOISE_XY**2 * motion.duration,
            (settings.drift_turn_rate * motion.odometry_gap) ** 2 + _PROCESS_NOISE_YAW**2 * motion.duration,
        ),
    )
    decay = math.exp(-motion.path_length(settings.drift_speed) / settings.bias_correlation_length)
    P = estimate.P.copy()
    # P ← F P Fᵀ: F of the pose from the left and from the right; F of the biases is ``decay`` times the identity.
    P[0] -= y * P[2]
    P[1] += x * P[2]
    P[:, 0] -= y * P[:, 2]
    P[:, 1] += x * P[:, 2]
    P[3:] *= decay
    P[:, 3:] *= decay
    P[:3, :3] += as_matrix(noise)
    P.ravel()[3 * (len(P) + 1) :: len(P) + 1] += 1.0 - decay * decay
    return Estimate(
        odometry,
        estimate.x + x,
        estimate.y + y,
        math.remainder(estimate.yaw + motion.yaw, math.tau),
        decay * estimate.bias,
        estimate.bias_sigmas,
        P,
    )


def compute_innovation(estimate: Estimate, pose: SE2) -> Vector:
    """Return the innovation: measured pose minus estimate [m, m, rad]."""
    return pose.x - estimate.x, pose.y - estimate.y, math.remainder(pose.yaw - estimate.yaw, math.tau)


def update(estimate: Estimate, innovation: Vector, source: int, noise: Covariance, bias_fraction: float) -> Estimate:
    """Measurement update with a pose z = p + √a L u + v: pose p, bias u of the source, white noise v.

    The bias is estimated only where the pose is more certain than this source alone could make it, which is the work of
    other sources. Elsewhere it is only considered (Schmidt-Kalman filter): it would absorb the bias of the odometry.

    Args:
        estimate: prediction at the stamp of the measurement.
        innovation: measured pose minus prediction [m, m, rad].
        source: source index.
        noise: covariance R = L Lᵀ of the measurement.
        bias_fraction: fraction a of R that is bias; the rest is the covariance of v.
    """
    L, columns, R = bias_sqrt(noise), _bias_columns(source), as_matrix(noise)
    estimate, bias_gain = _rescale_bias(estimate, source, L[_SIGMA_ENTRIES]), math.sqrt(bias_fraction) * L
    P = estimate.P
    PH = P[:, :3] + P[:, columns] @ bias_gain.T
    S = PH[:3] + bias_gain @ PH[columns] + (1.0 - bias_fraction) * R
    K = np.linalg.solve(S, PH.T).T
    if not _can_estimate_bias(P, bias_fraction * R):
        K[columns] = 0.0
    correction = K @ (np.array(innovation) - bias_gain @ estimate.bias[source])
    P = P - K @ PH.T - PH @ K.T + K @ S @ K.T
    dx, dy, dt = correction[:3].tolist()
    return Estimate(
        estimate.odometry,
        estimate.x + dx,
        estimate.y + dy,
        math.remainder(estimate.yaw + dt, math.tau),
        estimate.bias + correction[3:].reshape(-1, 3),
        estimate.bias_sigmas,
        0.5 * (P + P.T),
    )


def _rescale_bias(estimate: Estimate, source: int, sigmas: NDArray[np.float64]) -> Estimate:
    """Rescale the bias of a source to the standard deviations of its new pose.

    Where they have grown, an independent error was added to the old bias; where they have shrunk, the bias scales down.
    """
    columns, bias_sigmas = _bias_columns(source), estimate.bias_sigmas.copy()
    decay = np.minimum(bias_sigmas[source] / np.maximum(sigmas, _EPSILON), 1.0)
    bias_sigmas[source] = sigmas
    bias, P = estimate.bias.copy(), estimate.P.copy()
    bias[source] *= decay
    P[columns] *= decay[:, None]
    P[:, columns] *= decay
    P.ravel()[columns.start * (len(P) + 1) : columns.stop * (len(P) + 1) : len(P) + 1] += 1.0 - decay * decay
    return estimate._replace(bias=bias, bias_sigmas=bias_sigmas, P=P)


def _can_estimate_bias(P: NDArray[np.float64], bias: NDArray[np.float64]) -> bool:
    return bool(P[0, 0] + P[1, 1] < bias[0, 0] + bias[1, 1] and P[2, 2] < bias[2, 2])


def bias_sqrt(noise: Covariance) -> NDArray[np.float64]:
    """Return L with L Lᵀ = R, shape (3, 3), for errors (yaw, x, y) of unit variance.

    Yaw comes first: a source that sees one lamp or one door knows its position only as well as its yaw, so one bias
    affects both.
    """
    xx, xy, xt, yy, yt, tt = noise
    sigma_yaw = math.sqrt(tt)
    x, y = xt / sigma_yaw, yt / sigma_yaw
    along = math.sqrt(max(xx - x * x, 0.0))
    across = (xy - x * y) / along if along > 0.0 else 0.0
    rest = math.sqrt(max(yy - y * y - across * across, 0.0))
    return np.array(((x, along, 0.0), (y, across, rest), (sigma_yaw, 0.0, 0.0)))


def _bias_columns(source: int) -> slice:
    return slice(3 + 3 * source, 6 + 3 * source)


def diagonal(var_xy: float, var_yaw: float) -> Covariance:
    """Return a diagonal covariance, with the same variance along x and y [m²]."""
    return (var_xy, 0.0, 0.0, var_xy, 0.0, var_yaw)


def add_covariances(a: Covariance, b: Covariance) -> Covariance:
    """Return ``a + b``."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


def scale_covariance(a: Covariance, factor: float) -> Covariance:
    """Return ``factor a``."""
    return (a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor, a[4] * factor, a[5] * factor)


def rotate_covariance(a: Covariance, cos: float, sin: float) -> Covariance:
    """Return ``R a Rᵀ`` for a rotation about the z axis."""
    xx, xy, xt, yy, yt, tt = a
    rxx, rxy = cos * xx - sin * xy, cos * xy - sin * yy
    ryx, ryy = sin * xx + cos * xy, sin * xy + cos * yy
    return (
        rxx * cos - rxy * sin,
        rxx * sin + rxy * cos,
        cos * xt - sin * yt,
        ryx * sin + ryy * cos,
        sin * xt + cos * yt,
        tt,
    )


def inverse(a: Covariance) -> Covariance:
    """Return the inverse of a positive definite covariance (by its adjugate)."""
    xx, xy, xt, yy, yt, tt = a
    c0, c1, c2 = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    inverse_determinant = 1.0 / (xx * c0 + xy * c1 + xt * c2)
    return (
        c0 * inverse_determinant,
        c1 * inverse_determinant,
        c2 * inverse_determinant,
        (xx * tt - xt * xt) * inverse_determinant,
        (xy * xt - xx * yt) * inverse_determinant,
        (xx * yy - xy * xy) * inverse_determinant,
    )


def mahalanobis_squared(residual: Vector, information: Covariance) -> float:
    """Return the squared Mahalanobis distance of a residual, ``information`` being an inverse covariance."""
    x, y, t = residual
    xx, xy, xt, yy, yt, tt = information
    return x * (xx * x + 2.0 * (xy * y + xt * t)) + y * (yy * y + 2.0 * yt * t) + tt * t * t


def is_positive_definite(a: Covariance) -> bool:
    """Return whether all entries are finite and every leading minor is positive."""
    xx, xy, xt, yy, yt, tt = a
    if not all(map(math.isfinite, a)):
        return False
    minor = xx * yy - xy * xy
    determinant = xx * (yy * tt - yt * yt) - xy * (xy * tt - xt * yt) + xt * (xy * yt - xt * yy)
    return xx > 0.0 and minor > 0.0 and determinant > 0.0


def as_matrix(a: Covariance) -> NDArray[np.float64]:
    """Return the covariance as an array of shape (3, 3)."""
    xx, xy, xt, yy, yt, tt = a
    return np.array(((xx, xy, xt), (xy, yy, yt), (xt, yt, tt)))
