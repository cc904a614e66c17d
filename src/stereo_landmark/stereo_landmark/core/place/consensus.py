"""Consensus set of the displacement: RANSAC over all pairs of points.

Two points determine x, y, z and yaw of the robot; all other points are inliers or outliers of that hypothesis (Fischler
and Bolles 1981, but with all pairs instead of random samples, because a target has few points). In repetitive scenes,
outliers are consistent with each other: a whole row of squares is matched to the next row. All distances within such a
group are right, so the distance check does not detect it, but its displacement differs from that of the inliers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints

GATE_SIGMAS = 4.0
ANGLE_ERROR = 0.002
"""Extra direction error of points besides their noise, because the pose from one pair is coarse [rad]."""
PAIRS_MAX = 2000
"""Maximum number of tested pairs; more pairs are subsampled evenly."""
WIDTH_MIN = 0.02
"""Minimum horizontal distance of a pair; nearer points do not determine the yaw [m]."""


class Consensus(NamedTuple):
    """The inliers of the displacement hypothesis with the most support.

    Attributes:
        agreeing: mask of the inliers, shape (n,).
        votes: number of inliers, each weighted by how well it fits (MSAC score).
    """

    agreeing: NDArray[np.bool_]
    votes: float


def largest_consensus(found: SpatialPoints, taught: SpatialPoints, tilt_sigma: float) -> Consensus:
    """Return the consensus set of the displacement with the most support.

    Args:
        found: n current points in the gravity-aligned base frame.
        taught: the same points as taught, in the same order.
        tilt_sigma: standard deviation of the roll and pitch of that frame [rad].

    Returns:
        consensus set, without inliers where no two points are far enough apart to determine the yaw.
    """
    ranges = np.linalg.norm(found.positions, axis=1)
    spare = (max(ANGLE_ERROR, tilt_sigma) * ranges) ** 2
    spread = found.covariances + spare[:, None, None] * np.eye(3)
    pairs = np.array(np.triu_indices(len(found), 1), dtype=np.int64).T
    pairs = np.ascontiguousarray(pairs[:: 1 + (len(pairs) - 1) // PAIRS_MAX])
    votes = np.zeros((len(pairs), len(found)))
    _vote(found.positions, taught.positions, spread, taught.covariances, pairs, votes)
    if not len(pairs):
        return Consensus(np.zeros(len(found), dtype=np.bool_), 0.0)
    best = int(np.argmax(votes.sum(axis=1)))
    return Consensus(votes[best] > 0.0, float(votes[best].sum()))


@njit(cache=True, error_model='numpy')
def _vote(
    found: NDArray[np.float64],
    taught: NDArray[np.float64],
    spread: NDArray[np.float64],
    taught_spread: NDArray[np.float64],
    pairs: NDArray[np.int64],
    votes: NDArray[np.float64],
) -> None:
    """Write the score of each point under the hypothesis of each pair, shape (m, n), from 1 (exact) to 0 (outlier)."""
    # The trace bounds the variance along any direction: points beyond it are outliers without a full test.
    farthest = np.empty(len(found))
    for k in range(len(found)):
        farthest[k] = GATE_SIGMAS**2 * (np.trace(spread[k]) + np.trace(taught_spread[k]))
    off, noise = np.empty(3), np.empty((3, 3))
    for p in range(len(pairs)):
        i, j = pairs[p]
        hx, hy = found[j, 0] - found[i, 0], found[j, 1] - found[i, 1]
        tx, ty = taught[j, 0] - taught[i, 0], taught[j, 1] - taught[i, 1]
        if np.hypot(hx, hy) < WIDTH_MIN or np.hypot(tx, ty) < WIDTH_MIN:
            continue
        turn = np.arctan2(hy, hx) - np.arctan2(ty, tx)
        cos, sin = np.cos(turn), np.sin(turn)
        mx, my, mz = 0.5 * (found[i] + found[j])
        nx, ny, nz = 0.5 * (taught[i] + taught[j])
        for k in range(len(found)):
            dx, dy = taught[k, 0] - nx, taught[k, 1] - ny
            off[0] = found[k, 0] - mx - cos * dx + sin * dy
            off[1] = found[k, 1] - my - sin * dx - cos * dy
            off[2] = found[k, 2] - mz - taught[k, 2] + nz
            if off[0] ** 2 + off[1] ** 2 + off[2] ** 2 < farthest[k]:
                _write_turned(taught_spread[k], cos, sin, noise)
                noise += spread[k]
                votes[p, k] = max(0.0, 1.0 - _square_in_sigmas(off, noise) / GATE_SIGMAS**2)


@njit(cache=True, error_model='numpy')
def _write_turned(
    covariance: NDArray[np.float64], cos: float, sin: float, turned: NDArray[np.float64]
) -> None:
    """Write a covariance, shape (3, 3), rotated about z."""
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    turned[0, 0] = cos * cos * xx - 2.0 * cos * sin * xy + sin * sin * yy
    turned[1, 1] = sin * sin * xx + 2.0 * cos * sin * xy + cos * cos * yy
    turned[0, 1] = turned[1, 0] = cos * sin * (xx - yy) + (cos * cos - sin * sin) * xy
    turned[0, 2] = turned[2, 0] = cos * covariance[0, 2] - sin * covariance[1, 2]
    turned[1, 2] = turned[2, 1] = sin * covariance[0, 2] + cos * covariance[1, 2]
    turned[2, 2] = covariance[2, 2]


@njit(cache=True, error_model='numpy')
def _square_in_sigmas(off: NDArray[np.float64], noise: NDArray[np.float64]) -> float:
    """Return the squared Mahalanobis distance of a residual, shape (3,), with covariance, shape (3, 3)."""
    total, determinant = 0.0, 0.0
    for r in range(3):
        a, b = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            minor = noise[a, d] * noise[b, e] - noise[a, e] * noise[b, d]
            total += off[r] * minor * off[c]
            determinant += noise[r, c] * minor / 3.0
    return total / determinant
