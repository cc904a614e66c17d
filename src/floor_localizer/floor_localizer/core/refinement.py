"""Refine a similarity to the full pose model: match and fit alternately until the matches converge.

A tilted camera shifts a dot at distance r from the centre of the view by up to tilt r^2 / height. A similarity does not
model this, and it may be many times the dots' noise. If too many dots are unmatched within the noise gate, the first
search radius includes this shift; later radii follow from the residuals of the previous fit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import GATE
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.pose_fit import MountedRays, fit_pose, project_to_map

_MAX_FITS = 8
# Search radius of the first fit [gates].
_FIRST_GATES = 2.5
# The tilt is included in the search radius only if the radius without it misses more than this fraction of the matches:
# a few missing ones are outliers, and with few dots a false tilt would fit them.
_UNMATCHED_FRACTION = 0.3
# Maximum search radius for the tilt [mean dot spacings]; beyond it, matches are random.
_MAX_TILT_RADIUS = 0.25
_MAX_RADIUS = 0.45
# Median length of a normally distributed 2D vector with unit standard deviation along each axis.
_MEDIAN_LENGTH = math.sqrt(2.0 * math.log(2.0))
# Confidence margin of a median [standard deviations of the median].
_CONFIDENCE_SIGMAS = 2.0


class Refinement(NamedTuple):
    """The fitted pose.

    Attributes:
        state: shape (6,): x, y [m], yaw [rad], scale, roll, pitch [rad].
        covariance: shape (6, 6), covariance of the state.
        matches: shape (n,), index of each dot's map dot in the grid, -1 without a match.
    """

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    matches: NDArray[np.int64]


@njit(cache=True)
def refine_pose(
    grid: DotGrid,
    mounted: MountedRays,
    sigmas: NDArray[np.float64],
    start: NDArray[np.float64],
    prior_sigmas: NDArray[np.float64],
) -> Refinement:
    """Fit the full model to all dots that match the map under it.

    Args:
        grid: the map.
        mounted: the rays of n dots and the camera's mount.
        sigmas: shape (n,), standard deviations of the dots' positions [m].
        start: shape (6,), initial state.
        prior_sigmas: shape (3,), prior standard deviations of scale, roll and pitch [-, rad, rad].
    """
    n = len(sigmas)
    state = start.copy()
    covariance = np.zeros((6, 6))
    matches = np.full(n, -1)
    previous = np.full(n, -2)
    targets = np.zeros((n, 2))
    radii = np.minimum(_FIRST_GATES * GATE * sigmas, _MAX_RADIUS * grid.cell)
    tilt_radii = np.maximum(_radii_with_tilt(grid, mounted, sigmas, state, prior_sigmas), radii)
    near_count = _match_dots(grid, mounted, state, radii, matches, targets)
    if near_count < (1.0 - _UNMATCHED_FRACTION) * _match_dots(
        grid, mounted, state, tilt_radii, matches, targets
    ):
        radii = tilt_radii
    for _ in range(_MAX_FITS):
        if _match_dots(grid, mounted, state, radii, matches, targets) < 3:
            break
        covariance = fit_pose(mounted, targets, sigmas, matches >= 0, prior_sigmas, state)
        if _is_unchanged(matches, previous):
            break
        gate = GATE * max(1.0, _residual_scale(mounted, state, matches, targets, sigmas))
        radii = np.minimum(np.minimum(gate * sigmas, radii), _MAX_RADIUS * grid.cell)
    return Refinement(state, covariance, matches)


@njit(cache=True)
def _is_unchanged(matches: NDArray[np.int64], previous: NDArray[np.int64]) -> bool:
    """Return whether all matches equal the previous ones, and copy them to the previous ones."""
    same = True
    for k in range(len(matches)):
        same = same and matches[k] == previous[k]
        previous[k] = matches[k]
    return same


@njit(cache=True)
def _radii_with_tilt(
    grid: DotGrid,
    mounted: MountedRays,
    sigmas: NDArray[np.float64],
    state: NDArray[np.float64],
    prior_sigmas: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the search radius of each dot for an unknown tilt, shape (n,) [m]."""
    n = len(sigmas)
    places = np.empty((n, 2))
    for k in range(n):
        places[k, 0], places[k, 1] = project_to_map(mounted, k, state)
    middle_x, middle_y = np.mean(places[:, 0]), np.mean(places[:, 1])
    squares = (places[:, 0] - middle_x) ** 2 + (places[:, 1] - middle_y) ** 2
    # Tolerance of a uniform distribution: sqrt(3) standard deviations.
    tilt = math.sqrt(3.0) * max(prior_sigmas[1], prior_sigmas[2])
    shifts = np.minimum(tilt / mounted.position[2] * squares, _MAX_TILT_RADIUS * grid.cell)
    return GATE * sigmas + shifts


@njit(cache=True)
def _match_dots(
    grid: DotGrid,
    mounted: MountedRays,
    state: NDArray[np.float64],
    radii: NDArray[np.float64],
    matches: NDArray[np.int64],
    targets: NDArray[np.float64],
) -> int:
    """Write each dot's map dot within its radius, or -1, and its position; return the number of matches."""
    matched = 0
    for k in range(len(radii)):
        x, y = project_to_map(mounted, k, state)
        matches[k] = nearest_dot(grid, x, y, radii[k])[0]
        if matches[k] >= 0:
            targets[k, 0] = grid.points[matches[k], 0]
            targets[k, 1] = grid.points[matches[k], 1]
            matched += 1
    return matched


@njit(cache=True)
def _residual_scale(
    mounted: MountedRays,
    state: NDArray[np.float64],
    matches: NDArray[np.int64],
    targets: NDArray[np.float64],
    sigmas: NDArray[np.float64],
) -> float:
    """Return a lower confidence bound of the residuals over the dots' standard deviations, from the median, which is
    robust to outliers.
    """
    ratios = np.empty(len(sigmas))
    count = 0
    for k in range(len(sigmas)):
        if matches[k] >= 0:
            x, y = project_to_map(mounted, k, state)
            ratios[count] = math.hypot(x - targets[k, 0], y - targets[k, 1]) / sigmas[k]
            count += 1
    confidence_factor = 1.0 - _CONFIDENCE_SIGMAS / (_MEDIAN_LENGTH * _MEDIAN_LENGTH * math.sqrt(count))
    return float(confidence_factor * np.median(ratios[:count]) / _MEDIAN_LENGTH)
