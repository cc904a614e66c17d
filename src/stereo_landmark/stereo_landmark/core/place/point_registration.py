"""Registration of the points of a place with the taught ones: inliers, then the paper's closed form (3.1; 3.4, end).

1. Consensus: two points determine x, y, z and yaw of the robot; all other points are inliers or outliers of that
   hypothesis (RANSAC, Fischler and Bolles 1981, but with all pairs instead of random samples, because a target has few
   points). In repetitive scenes, outliers are consistent with each other: a whole row of squares is matched to the next
   row. All distances within such a group are right, so the distance test does not detect it, but its displacement
   differs from that of the inliers.
2. Distance test (3.4, end): distances between points must equal the taught ones.
3. Closed form (3.1): dx, dy, dz and theta_z between the taught and the current pose. The equation maps taught points to
   current ones, ``x = Rz(-theta_z) x_t + d``. The robot's pose in the taught frame is the inverse: its yaw is
   ``+theta_z`` and its position ``-Rz(theta_z) d``.
"""

import cmath
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from shirube_core.geometry import SE2
from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.stereo import SpatialPoints

GATE_SIGMAS = 4.0
BEARING_ERROR = 0.002
"""Extra direction error of points besides their noise, because the pose from one pair is coarse [rad]."""
PAIRS_MAX = 2000
"""Maximum number of tested pairs; more pairs are subsampled evenly."""
PAIR_DISTANCE_MIN = 0.02
"""Minimum horizontal distance of a pair; nearer points do not determine the yaw [m]."""


class ConsensusSet(NamedTuple):
    """The inliers of the displacement hypothesis with the most support.

    Attributes:
        inliers: mask of the inliers, shape (n,).
        support: number of inliers, each weighted by how well it fits (MSAC score).
    """

    inliers: Masks
    support: float


def find_consensus_set(found: SpatialPoints, taught: SpatialPoints, tilt_sigma: float) -> ConsensusSet:
    """Return the consensus set of the displacement with the most support.

    Args:
        found: n current points in the gravity-aligned base frame.
        taught: the same points as taught, in the same order.
        tilt_sigma: standard deviation of the roll and pitch of that frame [rad].

    Returns:
        consensus set, without inliers where no two points are far enough apart to determine the yaw.
    """
    ranges = np.linalg.norm(found.positions, axis=1)
    margin_variances = (max(BEARING_ERROR, tilt_sigma) * ranges) ** 2
    found_covariances = found.covariances + margin_variances[:, None, None] * np.eye(3)
    pairs = np.array(np.triu_indices(len(found), 1), dtype=np.int64).T
    pairs = np.ascontiguousarray(pairs[:: 1 + max(len(pairs) - 1, 0) // PAIRS_MAX])
    support = np.zeros((len(pairs), len(found)))
    _score_pairs(found.positions, taught.positions, found_covariances, taught.covariances, pairs, support)
    if not len(pairs):
        return ConsensusSet(np.zeros(len(found), dtype=np.bool_), 0.0)
    best = int(np.argmax(support.sum(axis=1)))
    return ConsensusSet(support[best] > 0.0, float(support[best].sum()))


@njit(cache=True, error_model='numpy')
def _score_pairs(
    found: Floats, taught: Floats, found_covariances: Floats, taught_covariances: Floats, pairs: Ints, support: Floats
) -> None:
    """Write the score of each point under the hypothesis of each pair, shape (m, n), from 1 (exact) to 0 (outlier)."""
    # The trace bounds the variance along any direction: points beyond it are outliers without a full test.
    distance_gates = np.empty(len(found))
    for k in range(len(found)):
        distance_gates[k] = GATE_SIGMAS**2 * (np.trace(found_covariances[k]) + np.trace(taught_covariances[k]))
    residual, noise = np.empty(3), np.empty((3, 3))
    for p in range(len(pairs)):
        i, j = pairs[p]
        hx, hy = found[j, 0] - found[i, 0], found[j, 1] - found[i, 1]
        tx, ty = taught[j, 0] - taught[i, 0], taught[j, 1] - taught[i, 1]
        if np.hypot(hx, hy) < PAIR_DISTANCE_MIN or np.hypot(tx, ty) < PAIR_DISTANCE_MIN:
            continue
        turn = np.arctan2(hy, hx) - np.arctan2(ty, tx)
        cos, sin = np.cos(turn), np.sin(turn)
        mx, my, mz = 0.5 * (found[i] + found[j])
        nx, ny, nz = 0.5 * (taught[i] + taught[j])
        for k in range(len(found)):
            dx, dy = taught[k, 0] - nx, taught[k, 1] - ny
            residual[0] = found[k, 0] - mx - cos * dx + sin * dy
            residual[1] = found[k, 1] - my - sin * dx - cos * dy
            residual[2] = found[k, 2] - mz - taught[k, 2] + nz
            if residual[0] ** 2 + residual[1] ** 2 + residual[2] ** 2 < distance_gates[k]:
                _rotate_covariance(taught_covariances[k], cos, sin, noise)
                noise += found_covariances[k]
                support[p, k] = max(0.0, 1.0 - _squared_mahalanobis(residual, noise) / GATE_SIGMAS**2)


@njit(cache=True, error_model='numpy')
def _rotate_covariance(covariance: Floats, cos: float, sin: float, rotated: Floats) -> None:
    """Write a covariance, shape (3, 3), rotated about z."""
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    rotated[0, 0] = cos * cos * xx - 2.0 * cos * sin * xy + sin * sin * yy
    rotated[1, 1] = sin * sin * xx + 2.0 * cos * sin * xy + cos * cos * yy
    rotated[0, 1] = rotated[1, 0] = cos * sin * (xx - yy) + (cos * cos - sin * sin) * xy
    rotated[0, 2] = rotated[2, 0] = cos * covariance[0, 2] - sin * covariance[1, 2]
    rotated[1, 2] = rotated[2, 1] = sin * covariance[0, 2] + cos * covariance[1, 2]
    rotated[2, 2] = covariance[2, 2]


@njit(cache=True, error_model='numpy')
def _squared_mahalanobis(residual: Floats, noise: Floats) -> float:
    """Return the squared Mahalanobis distance of a residual, shape (3,), with covariance, shape (3, 3)."""
    total, determinant = 0.0, 0.0
    for r in range(3):
        a, b = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            minor = noise[a, d] * noise[b, e] - noise[a, e] * noise[b, d]
            total += residual[r] * minor * residual[c]
            determinant += noise[r, c] * minor / 3.0
    return total / determinant


DISTANCE_ERROR = 0.002
"""Systematic error of a distance, from illumination, viewpoint and the detected centre [m]."""


def consistent_points(found: SpatialPoints, taught: SpatialPoints) -> Masks:
    """Return the mask of points with consistent pairwise distances, shape (n,).

    While some distance is inconsistent, the point with the most inconsistent distances is rejected; in a tie, the one
    with the largest error. If only two points are left and disagree, both are rejected.

    Args:
        found: n current points in any frame.
        taught: the same points as taught, in the same order, in any frame.
    """
    errors = _distance_errors(found, taught)
    kept = np.ones(len(found), dtype=np.bool_)
    while kept.any():
        wrong = (errors > GATE_SIGMAS) & kept & kept[:, None]
        counts = wrong.sum(axis=1)
        if not counts.any():
            break
        worst = np.flatnonzero(counts == counts.max())
        if counts.max() == 1 and kept.sum() == 2:
            kept[:] = False
            break
        sums = np.where(wrong, errors, 0.0).sum(axis=1)
        kept[worst[np.argmax(sums[worst])]] = False
    return kept


def _distance_errors(found: SpatialPoints, taught: SpatialPoints) -> Floats:
    """Return the error of each distance in standard deviations, shape (n, n)."""
    (lengths, spreads), (taught_lengths, taught_spreads) = _distances(found), _distances(taught)
    spread = np.sqrt(spreads + taught_spreads + DISTANCE_ERROR**2)
    return np.asarray(np.abs(lengths - taught_lengths) / spread)


def _distances(points: SpatialPoints) -> tuple[Floats, Floats]:
    """Return the distances [m] and their variances [m²], both of shape (n, n)."""
    offsets = points.positions[:, None] - points.positions[None]
    lengths = np.linalg.norm(offsets, axis=2)
    along = offsets / np.maximum(lengths, 1e-9)[:, :, None]
    covariances = points.covariances[:, None] + points.covariances[None]
    return lengths, np.einsum('ijk,ijkl,ijl->ij', along, covariances, along)


SPREAD_MIN = 0.005
"""Minimum horizontal RMS distance of the points from their mean; below it the yaw is not observable [m]."""


@dataclass(frozen=True)
class Displacement:
    """The displacement parameters of the paper (section 3.1).

    Attributes:
        dx: translation along x from the rotated taught points to the current ones [m].
        dy: translation along y [m].
        dz: translation along z [m].
        theta_z: yaw of the robot relative to the taught pose, counter-clockwise [rad].
    """

    dx: float
    dy: float
    dz: float
    theta_z: float

    @property
    def pose(self) -> SE2:
        """``T_place_base``: pose of the robot in the taught frame."""
        place = -cmath.rect(1.0, self.theta_z) * complex(self.dx, self.dy)
        return SE2(place.real, place.imag, self.theta_z)

    @property
    def height(self) -> float:
        """Height of the robot above the taught pose [m]."""
        return -self.dz

    @property
    def state(self) -> Floats:
        """x, y, z [m] and yaw [rad] of the robot in the taught frame, shape (4,)."""
        pose = self.pose
        return np.array([pose.x, pose.y, self.height, pose.yaw])


def closed_form(found: Floats, taught: Floats) -> Displacement | None:
    """Return the least-squares displacement from taught to current points.

    Args:
        found: current points in the gravity-aligned base frame, shape (n, 3) [m].
        taught: the same points as taught, shape (n, 3) [m].

    Returns:
        None for fewer than two points, or for points on one vertical line, which leave the yaw unobservable.
    """
    if len(found) < 2:
        return None
    mean, taught_mean = found.mean(axis=0), taught.mean(axis=0)
    here = (found - mean)[:, :2] @ np.array([1.0, 1.0j])
    there = (taught - taught_mean)[:, :2] @ np.array([1.0, 1.0j])
    if float(np.mean(np.abs(there) ** 2)) < SPREAD_MIN**2:
        return None
    turn = -cmath.phase(complex(np.sum(here * there.conj())))
    shift = complex(mean[0], mean[1]) - cmath.rect(1.0, -turn) * complex(*taught_mean[:2])
    return Displacement(shift.real, shift.imag, float(mean[2] - taught_mean[2]), turn)


def closed_form_covariance(found: SpatialPoints, taught: SpatialPoints) -> Floats:
    """Propagate the noise of the points to the covariance of the closed-form displacement.

    Args:
        found: current points in the gravity-aligned base frame, for which the closed form exists.
        taught: the same points as taught, in the same order.

    Returns:
        covariance of x, y, z [m] and yaw [rad] of the robot in the taught frame, shape (4, 4).
    """
    mean, taught_mean = found.positions.mean(axis=0), taught.positions.mean(axis=0)
    here = (found.positions - mean)[:, :2] @ np.array([1.0, 1.0j])
    there = (taught.positions - taught_mean)[:, :2] @ np.array([1.0, 1.0j])
    total = np.sum(here * there.conj())
    # theta_z = -arg(total); x + iy = taught mean - exp(i theta_z) mean; z = taught mean - mean.
    turn = np.exp(-1j * np.angle(total))
    covariance = np.zeros((4, 4))
    for points, partner, sign in ((found, there, -1.0), (taught, here, 1.0)):
        jacobians = np.zeros((len(points), 4, 3))
        for axis, unit in enumerate((1.0, 1.0j)):
            change = unit * partner.conj() if sign < 0.0 else partner * np.conj(unit)
            yaws = -np.imag(change / total)
            moves = sign * (turn if sign < 0.0 else 1.0) * unit / len(points)
            places = moves - 1j * yaws * turn * complex(*mean[:2])
            jacobians[:, :, axis] = np.column_stack([places.real, places.imag, 0.0 * yaws, yaws])
        jacobians[:, 2, 2] = sign / len(points)
        covariance += np.einsum('nij,njk,nlk->il', jacobians, points.covariances, jacobians)
    return covariance
