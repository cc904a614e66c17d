"""From a pose by similarity to the pose by the whole model: match again under it, fit again, until the
matches stay.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import GATE
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.pose_fit import MountedRays, fit_pose, map_point

# The first matches reach farther, because tilt is not known yet.
_REACHES = (2.5, 1.5, 1.0, 1.0, 1.0, 1.0)


class Refinement(NamedTuple):
    """The fitted pose.

    Attributes:
        state: shape (6,): x, y [m], yaw [rad], scale, roll, pitch [rad].
        covariance: shape (6, 6), of the state.
        matches: shape (n,), index of each dot's map dot in the grid, -1 where there is none.
    """

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    matches: NDArray[np.int64]


@njit(cache=True)
def refine(
    grid: DotGrid,
    mounted: MountedRays,
    sigmas: NDArray[np.float64],
    start: NDArray[np.float64],
    prior_sigmas: NDArray[np.float64],
) -> Refinement:
    """Fit the whole model to all dots that match the map under it.

    Args:
        grid: the map.
        mounted: the rays of n dots and the camera's mount.
        sigmas: shape (n,), standard deviation of each dot's place [m].
        start: shape (6,), a state near the right one.
        prior_sigmas: shape (3,), of scale and tilts.
    """
    n = len(sigmas)
    state = start.copy()
    covariance = np.zeros((6, 6))
    matches = np.full(n, -1)
    previous = np.full(n, -2)
    targets = np.zeros((n, 2))
    for reach in _REACHES:
        for k in range(n):
            x, y = map_point(mounted, k, state)
            matches[k] = nearest_dot(grid, x, y, min(reach * GATE * sigmas[k], 0.45 * grid.cell))[0]
            if matches[k] >= 0:
                targets[k, 0] = grid.points[matches[k], 0]
                targets[k, 1] = grid.points[matches[k], 1]
        if np.sum(matches >= 0) < 3:
            break
        covariance = fit_pose(mounted, targets, sigmas, matches >= 0, prior_sigmas, state)
        if reach == 1.0 and np.all(matches == previous):
            break
        previous[:] = matches
    return Refinement(state, covariance, matches)
