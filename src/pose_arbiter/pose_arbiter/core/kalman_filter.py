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

Covariance = NDArray[np.float64]
"""Covariance of (x, y, yaw), shape (3, 3) [m, rad]."""


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
        return self.P[:3, :3]


def initialize(odometry: CumulativeOdometry, pose: SE2, noise: Covariance, sources: int) -> Estimate:
    """Return the initial estimate from a prior pose and its covariance, for a number of sources."""
    P = np.eye(3 + 3 * sources)
    P[:3, :3] = noise
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
    R = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    noise = R @ odometry_noise @ R.T + diagonal(
        (settings.drift_speed * motion.odometry_gap) ** 2 + _PROCESS_NOISE_XY**2 * motion.duration,
        (settings.drift_turn_rate * motion.odometry_gap) ** 2 + _PROCESS_NOISE_YAW**2 * motion.duration,
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
    P[:3, :3] += noise
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


def compute_innovation(estimate: Estimate, pose: SE2) -> NDArray[np.float64]:
    """Return the innovation: measured pose minus estimate, shape (3,) [m, m, rad]."""
    yaw = math.remainder(pose.yaw - estimate.yaw, math.tau)
    return np.array((pose.x - estimate.x, pose.y - estimate.y, yaw))


def update(
    estimate: Estimate, innovation: NDArray[np.float64], source: int, noise: Covariance, bias_fraction: float
) -> Estimate:
    """Measurement update with a pose z = p + √a L u + v: pose p, bias u of the source, white noise v.

    The bias is estimated only where the pose is more certain than this source alone could make it, which is the work of
    other sources. Elsewhere it is only considered (Schmidt-Kalman filter): it would absorb the bias of the odometry.

    Args:
        estimate: prediction at the stamp of the measurement.
        innovation: measured pose minus prediction, shape (3,) [m, m, rad].
        source: source index.
        noise: covariance R = L Lᵀ of the measurement.
        bias_fraction: fraction a of R that is bias; the rest is the covariance of v.
    """
    L, columns = bias_sqrt(noise), _bias_columns(source)
    estimate, bias_gain = _rescale_bias(estimate, source, L[_SIGMA_ENTRIES]), math.sqrt(bias_fraction) * L
    P = estimate.P
    PH = P[:, :3] + P[:, columns] @ bias_gain.T
    S = PH[:3] + bias_gain @ PH[columns] + (1.0 - bias_fraction) * noise
    K = np.linalg.solve(S, PH.T).T
    if not _can_estimate_bias(P, bias_fraction * noise):
        K[columns] = 0.0
    correction = K @ (innovation - bias_gain @ estimate.bias[source])
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
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = noise.tolist()
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
    return np.diag((var_xy, var_xy, var_yaw))


def is_positive_definite(a: Covariance) -> bool:
    """Return whether all entries are finite and every leading minor is positive."""
    if not np.isfinite(a).all():
        return False
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = a.tolist()
    minor = xx * yy - xy * xy
    determinant = xx * (yy * tt - yt * yt) - xy * (xy * tt - xt * yt) + xt * (xy * yt - xt * yy)
    return xx > 0.0 and minor > 0.0 and determinant > 0.0
