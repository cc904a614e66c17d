"""Which points tell the same displacement: a vote of all pairs of points.

Two points give x, y, z and yaw of the robot, and all others agree with that or not (Fischler and Bolles 1981, but with
all pairs instead of random ones, for a target has few points). Where something repeats, wrong matches come as a
family: a whole row of squares is taken for the next one. Within such a family all distances are right, so that the
comparison of distances does not see it, but its displacement is not that of the others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints

GATE_SIGMAS = 4.0
ANGLE_ERROR = 0.002
"""Directions of points are allowed to be off by this besides their noise, for a pair tells the pose coarsely [rad]."""
PAIRS_MAX = 2000
"""Pairs that are tried; of more, evenly spread ones."""
WIDTH_MIN = 0.02
"""Points that are nearer together, seen from above, do not tell a turn [m]."""


class Consensus(NamedTuple):
    """The displacement for which most points vote.

    Attributes:
        agreeing: shape (n,), which points do.
        votes: how many they are, each less by how far it is off.
    """

    agreeing: NDArray[np.bool_]
    votes: float


def largest_consensus(found: SpatialPoints, taught: SpatialPoints, tilt_sigma: float) -> Consensus:
    """Return the points that tell the displacement for which most vote.

    Args:
        found: n points as measured now, in the level base frame.
        taught: the same points as taught, in the same order.
        tilt_sigma: how well that frame is known to be level [rad].

    Returns:
        nobody agrees where no two points are apart enough to tell a turn.
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
    """Fill in how much each point agrees with each pair, shape (m, n), 1 fully to 0 not at all."""
    # No direction is less certain than all directions together: what is farther off need not be looked at closely.
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
    """Write a covariance, shape (3, 3), turned about z."""
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    turned[0, 0] = cos * cos * xx - 2.0 * cos * sin * xy + sin * sin * yy
    turned[1, 1] = sin * sin * xx + 2.0 * cos * sin * xy + cos * cos * yy
    turned[0, 1] = turned[1, 0] = cos * sin * (xx - yy) + (cos * cos - sin * sin) * xy
    turned[0, 2] = turned[2, 0] = cos * covariance[0, 2] - sin * covariance[1, 2]
    turned[1, 2] = turned[2, 1] = sin * covariance[0, 2] + cos * covariance[1, 2]
    turned[2, 2] = covariance[2, 2]


@njit(cache=True, error_model='numpy')
def _square_in_sigmas(off: NDArray[np.float64], noise: NDArray[np.float64]) -> float:
    """Return the squared length of an offset, shape (3,), in standard deviations of its noise, shape (3, 3)."""
    total, determinant = 0.0, 0.0
    for r in range(3):
        a, b = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            minor = noise[a, d] * noise[b, e] - noise[a, e] * noise[b, d]
            total += off[r] * minor * off[c]
            determinant += noise[r, c] * minor / 3.0
    return total / determinant
