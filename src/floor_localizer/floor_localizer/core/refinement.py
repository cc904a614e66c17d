"""From a pose by similarity to the pose by the whole model: match again under it, fit again, until the
matches stay.

A tilted camera shifts a dot at distance r from the middle of the view by up to tilt r^2 / height, which no similarity
takes up and which may be many times the dots' noise. Where noise alone leaves dots out, they are first looked for that
far from where they should be; from then on the residuals of the fit before tell how far.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import GATE
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.pose_fit import MountedRays, fit_pose, map_point

_MOST_FITS = 8
# A dot of the first fit is looked for this many gates away,
_FIRST_GATES = 2.5
# and for the tilt, too, when that leaves out more than this share of the dots that are found so: a few that are left
# out are false, and few dots would be bent to them by a tilt that is not there,
_LEFT_OUT = 0.3
# but for the tilt no farther than this share of the mean spacing: beyond, a dot is found by chance.
_FARTHEST_BY_TILT = 0.25
_FARTHEST = 0.45
# The median length of a plane normal vector of unit deviation along each axis.
_MEDIAN_LENGTH = math.sqrt(2.0 * math.log(2.0))
# A median of many is certain to so many of its own standard deviations.
_CERTAIN = 2.0


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
    reaches = np.minimum(_FIRST_GATES * GATE * sigmas, _FARTHEST * grid.cell)
    tilted = np.maximum(_reaches_by_tilt(grid, mounted, sigmas, state, prior_sigmas), reaches)
    near = _match(grid, mounted, state, reaches, matches, targets)
    if near < (1.0 - _LEFT_OUT) * _match(grid, mounted, state, tilted, matches, targets):
        reaches = tilted
    for _ in range(_MOST_FITS):
        if _match(grid, mounted, state, reaches, matches, targets) < 3:
            break
        covariance = fit_pose(mounted, targets, sigmas, matches >= 0, prior_sigmas, state)
        if _stayed(matches, previous):
            break
        gate = GATE * max(1.0, _spread(mounted, state, matches, targets, sigmas))
        reaches = np.minimum(np.minimum(gate * sigmas, reaches), _FARTHEST * grid.cell)
    return Refinement(state, covariance, matches)


@njit(cache=True)
def _stayed(matches: NDArray[np.int64], previous: NDArray[np.int64]) -> bool:
    """Tell whether all matches are the previous ones, and make them the previous ones."""
    same = True
    for k in range(len(matches)):
        same = same and matches[k] == previous[k]
        previous[k] = matches[k]
    return same


@njit(cache=True)
def _reaches_by_tilt(
    grid: DotGrid,
    mounted: MountedRays,
    sigmas: NDArray[np.float64],
    state: NDArray[np.float64],
    prior_sigmas: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return how far off each dot may be while the tilt is not known, shape (n,) [m]."""
    n = len(sigmas)
    places = np.empty((n, 2))
    for k in range(n):
        places[k, 0], places[k, 1] = map_point(mounted, k, state)
    middle_x, middle_y = np.mean(places[:, 0]), np.mean(places[:, 1])
    squares = (places[:, 0] - middle_x) ** 2 + (places[:, 1] - middle_y) ** 2
    # A tolerance is the square root of 3 standard deviations of what is uniform within it.
    tilt = math.sqrt(3.0) * max(prior_sigmas[1], prior_sigmas[2])
    shifts = np.minimum(tilt / mounted.position[2] * squares, _FARTHEST_BY_TILT * grid.cell)
    return GATE * sigmas + shifts


@njit(cache=True)
def _match(
    grid: DotGrid,
    mounted: MountedRays,
    state: NDArray[np.float64],
    reaches: NDArray[np.float64],
    matches: NDArray[np.int64],
    targets: NDArray[np.float64],
) -> int:
    """Write each dot's map dot within its reach, or -1, and where that is; return the number of matches."""
    matched = 0
    for k in range(len(reaches)):
        x, y = map_point(mounted, k, state)
        matches[k] = nearest_dot(grid, x, y, reaches[k])[0]
        if matches[k] >= 0:
            targets[k, 0] = grid.points[matches[k], 0]
            targets[k, 1] = grid.points[matches[k], 1]
            matched += 1
    return matched


@njit(cache=True)
def _spread(
    mounted: MountedRays,
    state: NDArray[np.float64],
    matches: NDArray[np.int64],
    targets: NDArray[np.float64],
    sigmas: NDArray[np.float64],
) -> float:
    """Return by how much the residuals exceed the dots' standard deviations for certain, by their median: few false
    matches do not count.
    """
    ratios = np.empty(len(sigmas))
    count = 0
    for k in range(len(sigmas)):
        if matches[k] >= 0:
            x, y = map_point(mounted, k, state)
            ratios[count] = math.hypot(x - targets[k, 0], y - targets[k, 1]) / sigmas[k]
            count += 1
    surely = 1.0 - _CERTAIN / (_MEDIAN_LENGTH * _MEDIAN_LENGTH * math.sqrt(count))
    return float(surely * np.median(ratios[:count]) / _MEDIAN_LENGTH)
