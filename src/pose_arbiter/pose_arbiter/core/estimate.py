"""The robot's pose with its covariance, how it moves on and how a measurement mends it.

Beside the pose the state has three lasting errors for each source: poses of one source err alike, and a filter that
took them for independent would believe the one that speaks most often. Where sources differ, what each is off is
learned and kept, so that the better one is not forgotten while only the other one speaks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import Covariance, added, as_matrix, diagonal, turned
from pose_arbiter.core.odometry_mark import OdometryMark, motion_between

_CREEP_XY, _CREEP_YAW = 2e-3, 2e-3  # what nobody sees, after a second [m, rad]
_SIZES = (2, 0, 1), (0, 1, 2)  # in `lasting_root`: of the heading, then along and across
_LEAST = 1e-12  # what divides [m, rad]


class Estimate(NamedTuple):
    """A pose at an instant.

    Attributes:
        mark: odometry at that instant.
        x, y, yaw: ``T_map_base`` [m, rad].
        lasting: shape (s, 3), lasting errors of the sources, in standard deviations (`lasting_root`).
        sizes: shape (s, 3), those standard deviations at the latest pose of each source.
        P: shape (3 + 3 s, 3 + 3 s), covariance of (x, y, yaw) [m, rad] and of those errors.
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
        """Of (x, y, yaw)."""
        (xx, xy, xt), (_, yy, yt), (_, _, tt) = self.P[:3, :3].tolist()
        return (xx, xy, xt, yy, yt, tt)


def told(mark: OdometryMark, x: float, y: float, yaw: float, noise: Covariance, sources: int) -> Estimate:
    """Return the estimate at a pose of which nothing but a covariance is known, with so many sources to come."""
    P = np.eye(3 + 3 * sources)
    P[:3, :3] = as_matrix(noise)
    return Estimate(mark, x, y, yaw, np.zeros((sources, 3)), np.full((sources, 3), np.inf), P)


def measured(begin: Estimate, source: int, noise: Covariance, share: float) -> Estimate:
    """Return an estimate that was `told` as one that a source measured, which errs as it does.

    Args:
        begin: from `told`, with a covariance not less than the noise.
        source: its number.
        noise: R, covariance of the measurement.
        share: share of R that lasts.
    """
    P, columns, sizes, root = begin.P.copy(), _columns(source), begin.sizes.copy(), lasting_root(noise)
    P[:3, columns] = -math.sqrt(share) * root
    P[columns, :3] = P[:3, columns].T
    sizes[source] = root[_SIZES]
    return begin._replace(sizes=sizes, P=P)


def moved_on(estimate: Estimate, mark: OdometryMark, settings: ArbiterSettings) -> Estimate:
    """Return the estimate at a later mark: moved by odometry, less sure, what lasts partly gone."""
    motion = motion_between(estimate.mark, mark)
    between = estimate.yaw - estimate.mark.yaw  # trail to map
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
    # F of the pose from the left and from the right; that of what lasts is ``kept`` times one.
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
    """Return how a measured pose differs from the estimate [m, m, rad]."""
    return x - estimate.x, y - estimate.y, math.remainder(yaw - estimate.yaw, math.tau)


def mended(
    estimate: Estimate, difference: tuple[float, float, float], source: int, noise: Covariance, share: float
) -> Estimate:
    """Return the estimate after a measurement: the pose, a lasting error and noise, z = p + √share L u + v.

    What lasts is learned where the estimate is surer than the source alone could make it: others have. Elsewhere it is
    only reckoned with (Schmidt's filter), since what wheels are lastingly off would be taken for it.

    Args:
        estimate: at the stamp of the measurement.
        difference: measured pose less estimate [m, m, rad].
        source: number of the source.
        noise: R = L Lᵀ, covariance of the measurement.
        share: share of R that lasts; the rest is v.
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
    """Return the estimate before a source's pose whose errors have another size.

    Where they have grown, something new has come on top of the old; where they have shrunk, all of it has.
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
    """Return L with L Lᵀ = R, shape (3, 3), for errors (yaw, along x, along y) that are one in size.

    The heading comes first: a source that sees one lamp or one door knows its place only as well as its heading, so
    that one lasting error does both.
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
