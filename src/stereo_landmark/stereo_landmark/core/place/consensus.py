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
    for p in range(len(pairs)):
        i, j = pairs[p]
        here, there = found[j, :2] - found[i, :2], taught[j, :2] - taught[i, :2]
        if np.hypot(here[0], here[1]) < WIDTH_MIN or np.hypot(there[0], there[1]) < WIDTH_MIN:
            continue
        turn = np.arctan2(here[1], here[0]) - np.arctan2(there[1], there[0])
        cos, sin = np.cos(turn), np.sin(turn)
        rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        shift = 0.5 * (found[i] + found[j] - rotation @ (taught[i] + taught[j]))
        for k in range(len(found)):
            off = found[k] - rotation @ taught[k] - shift
            noise = spread[k] + rotation @ taught_spread[k] @ rotation.T
            distance = off @ np.linalg.solve(noise, off)
            votes[p, k] = max(0.0, 1.0 - distance / GATE_SIGMAS**2)
