"""Extended Kalman filter of the robot's pose and the biases of the sources: predict and update.

The state is the pose and three Gauss-Markov biases of each source: poses of one source are correlated, and a filter
that treated them as independent would follow the source with the highest rate. Where sources differ, their biases are
estimated and kept, so that the more accurate one still counts while only the other one publishes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import Covariance, added, as_matrix, diagonal, turned
from pose_arbiter.core.odometry_mark import OdometryMark, motion_between

_CREEP_XY, _CREEP_YAW = 2e-3, 2e-3  # process noise after 1 s, standard deviations [m, rad]
_SIZES = (2, 0, 1), (0, 1, 2)  # entries of `bias_sqrt`: yaw, then along and across
_LEAST = 1e-12  # smallest divisor [m, rad]


class Estimate(NamedTuple):
    """State estimate of the filter at one stamp.

    Attributes:
        odometry: cumulative odometry at that stamp.
        x, y, yaw: ``T_map_base`` [m, rad].
        bias: shape (s, 3), biases u of the s sources, in units of their standard deviations (`bias_sqrt`).
        bias_sigmas: shape (s, 3), those standard deviations at the latest pose of each source [rad, m, m].
        P: shape (3 + 3 s, 3 + 3 s), covariance of (x, y, yaw) [m, rad] and of the biases.
    """

    mark: OdometryMark
    x: float
    y: float
    yaw: float
    lasting: NDArray[np.float64]
    sizes: NDArray[np.float64]
    P: NDArray[np.float64]

    @property
    def covariance(self) -> Covariance:
        """Covariance of (x, y, yaw)."""
        (xx, xy, xt), (_, yy, yt), (_, _, tt) = self.P[:3, :3].tolist()
        return (xx, xy, xt, yy, yt, tt)


def told(mark: OdometryMark, x: float, y: float, yaw: float, noise: Covariance, sources: int) -> Estimate:
    """Return the initial estimate from a prior pose and its covariance, for a number of sources."""
    P = np.eye(3 + 3 * sources)
    P[:3, :3] = as_matrix(noise)
    return Estimate(mark, x, y, yaw, np.zeros((sources, 3)), np.full((sources, 3), np.inf), P)


def measured(begin: Estimate, source: int, noise: Covariance, share: float) -> Estimate:
    """Return the initial estimate from a source's pose, correlated with the bias of that source.

    Args:
        begin: estimate from `initialize`, with a covariance not less than R.
        source: source index.
        noise: covariance R of the measurement.
        bias_fraction: fraction of R that is bias.
    """
    P, columns, sizes, root = begin.P.copy(), _columns(source), begin.sizes.copy(), lasting_root(noise)
    P[:3, columns] = -math.sqrt(share) * root
    P[columns, :3] = P[:3, columns].T
    sizes[source] = root[_SIZES]
    return begin._replace(sizes=sizes, P=P)


def moved_on(estimate: Estimate, mark: OdometryMark, settings: ArbiterSettings) -> Estimate:
    """Time update: move the estimate by odometry, P ← F P Fᵀ + Q, and decay the biases."""
    motion = motion_between(estimate.mark, mark)
    between = estimate.yaw - estimate.mark.yaw  # rotation from the buffer frame to the map
    cos, sin = math.cos(between), math.sin(between)
    x, y = cos * motion.x - sin * motion.y, sin * motion.x + cos * motion.y
    noise = added(
        turned(motion.covariance, cos, sin),
        diagonal(
            (settings.drift_speed * motion.blind) ** 2 + _CREEP_XY**2 * motion.seconds,
            (settings.drift_turn_rate * motion.blind) ** 2 + _CREEP_YAW**2 * motion.seconds,
        ),
    )
    kept = math.exp(-motion.moved(settings.drift_speed) / settings.lasting_way)
    P = estimate.P.copy()
    # P ← F P Fᵀ: F of the pose from the left and from the right; F of the biases is ``decay`` times the identity.
    P[0] -= y * P[2]
    P[1] += x * P[2]
    P[:, 0] -= y * P[:, 2]
    P[:, 1] += x * P[:, 2]
    P[3:] *= kept
    P[:, 3:] *= kept
    P[:3, :3] += as_matrix(noise)
    P.ravel()[3 * (len(P) + 1) :: len(P) + 1] += 1.0 - kept * kept
    return Estimate(
        mark,
        estimate.x + x,
        estimate.y + y,
        math.remainder(estimate.yaw + motion.yaw, math.tau),
        kept * estimate.lasting,
        estimate.sizes,
        P,
    )


def residual(estimate: Estimate, x: float, y: float, yaw: float) -> tuple[float, float, float]:
    """Return the innovation: measured pose minus estimate [m, m, rad]."""
    return x - estimate.x, y - estimate.y, math.remainder(yaw - estimate.yaw, math.tau)


def mended(
    estimate: Estimate, difference: tuple[float, float, float], source: int, noise: Covariance, share: float
) -> Estimate:
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
    root, columns, R = lasting_root(noise), _columns(source), as_matrix(noise)
    estimate, lever = _resized(estimate, source, root[_SIZES]), math.sqrt(share) * root
    P = estimate.P
    PH = P[:, :3] + P[:, columns] @ lever.T
    S = PH[:3] + lever @ PH[columns] + (1.0 - share) * R
    K = np.linalg.solve(S, PH.T).T
    if not _is_surer(P, share * R):
        K[columns] = 0.0
    change = K @ (np.array(difference) - lever @ estimate.lasting[source])
    P = P - K @ PH.T - PH @ K.T + K @ S @ K.T
    dx, dy, dt = change[:3].tolist()
    return Estimate(
        estimate.mark,
        estimate.x + dx,
        estimate.y + dy,
        math.remainder(estimate.yaw + dt, math.tau),
        estimate.lasting + change[3:].reshape(-1, 3),
        estimate.sizes,
        0.5 * (P + P.T),
    )


def _resized(estimate: Estimate, source: int, now: NDArray[np.float64]) -> Estimate:
    """Rescale the bias of a source to the standard deviations of its new pose.

    Where they have grown, an independent error was added to the old bias; where they have shrunk, the bias scales down.
    """
    columns, sizes = _columns(source), estimate.sizes.copy()
    kept = np.minimum(sizes[source] / np.maximum(now, _LEAST), 1.0)
    sizes[source] = now
    lasting, P = estimate.lasting.copy(), estimate.P.copy()
    lasting[source] *= kept
    P[columns] *= kept[:, None]
    P[:, columns] *= kept
    P.ravel()[columns.start * (len(P) + 1) : columns.stop * (len(P) + 1) : len(P) + 1] += 1.0 - kept * kept
    return estimate._replace(lasting=lasting, sizes=sizes, P=P)


def _is_surer(P: NDArray[np.float64], lasting: NDArray[np.float64]) -> bool:
    return bool(P[0, 0] + P[1, 1] < lasting[0, 0] + lasting[1, 1] and P[2, 2] < lasting[2, 2])


def lasting_root(noise: Covariance) -> NDArray[np.float64]:
    """Return L with L Lᵀ = R, shape (3, 3), for errors (yaw, x, y) of unit variance.

    Yaw comes first: a source that sees one lamp or one door knows its position only as well as its yaw, so one bias
    affects both.
    """
    xx, xy, xt, yy, yt, tt = noise
    turn = math.sqrt(tt)
    x, y = xt / turn, yt / turn
    along = math.sqrt(max(xx - x * x, 0.0))
    across = (xy - x * y) / along if along > 0.0 else 0.0
    rest = math.sqrt(max(yy - y * y - across * across, 0.0))
    return np.array(((x, along, 0.0), (y, across, rest), (turn, 0.0, 0.0)))


def _columns(source: int) -> slice:
    return slice(3 + 3 * source, 6 + 3 * source)
