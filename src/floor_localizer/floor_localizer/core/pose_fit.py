"""The pose from matched dots: least squares over the robot's pose, the camera's height and its tilt.

The robot is a rigid body on a soft suspension: it rises by a fraction of the camera's height and tilts about
``base_link``, together with the camera and its mount (c, R). With the ray v_i of a dot in the optical frame,

    d_i = Tilt R v_i,   o = Tilt c + (0, 0, scale c_z),   p_i = o_xy - o_z / d_iz * d_ixy,
    m_i = T_map_base p_i + noise

The six unknowns (x, y, yaw, scale, roll, pitch) minimise the squared residuals over the dots' variances plus the
squared scale and tilts over their prior variances, which model suspension and load. The covariance is the inverse of
the normal matrix, the Cramer-Rao bound of this model.

A similarity is refined to this model: match and fit alternately until the matches converge. A tilted camera shifts a
dot at distance r from the centre of the view by up to tilt r^2 / height, which a similarity does not model; it may be
many times the dots' noise. If too many dots are unmatched within the noise gate, the first search radius includes
this shift; later radii follow from the residuals of the previous fit.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Booleans, Floats, Ints
from floor_localizer.core.constellation.alignment import GATE
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot

STATE_SIZE = 6
_JACOBIAN_STEP = 1e-6
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


class MountedRays(NamedTuple):
    """Rays of the dots and the camera's mount.

    Attributes:
        rays: shape (n, 3), undistorted rays of the dots in the optical frame, not normalized.
        rotation: shape (3, 3), ``R_base_camera`` as mounted.
        position: shape (3,), optical centre in the base frame as mounted [m].
    """

    rays: Floats
    rotation: Floats
    position: Floats


@njit(cache=True)
def project_to_map(mounted: MountedRays, k: int, state: Floats) -> tuple[float, float]:
    """Return the intersection of dot ``k``'s ray with the floor, in the map frame [m].

    Args:
        mounted: the rays and the camera's mount.
        k: index of the dot.
        state: shape (6,), x, y [m], yaw [rad], scale (relative height error), roll and pitch [rad].
    """
    v, r = mounted.rays[k], mounted.rotation
    dx, dy, dz = _tilt(
        r[0, 0] * v[0] + r[0, 1] * v[1] + r[0, 2] * v[2],
        r[1, 0] * v[0] + r[1, 1] * v[1] + r[1, 2] * v[2],
        r[2, 0] * v[0] + r[2, 1] * v[1] + r[2, 2] * v[2],
        state,
    )
    ox, oy, oz = _tilt(mounted.position[0], mounted.position[1], mounted.position[2], state)
    ray_length = -(oz + mounted.position[2] * state[3]) / dz
    px, py = ox + ray_length * dx, oy + ray_length * dy
    cos, sin = math.cos(state[2]), math.sin(state[2])
    return state[0] + cos * px - sin * py, state[1] + sin * px + cos * py


@njit(cache=True)
def _tilt(x: float, y: float, z: float, state: Floats) -> tuple[float, float, float]:
    """Rotate a vector of the untilted base frame by the state's roll, then its pitch."""
    cos, sin = math.cos(state[4]), math.sin(state[4])
    y, z = cos * y - sin * z, sin * y + cos * z
    cos, sin = math.cos(state[5]), math.sin(state[5])
    return cos * x + sin * z, y, cos * z - sin * x


@njit(cache=True)
def fit_pose(
    mounted: MountedRays, targets: Floats, sigmas: Floats, matched: Booleans, prior_sigmas: Floats, state: Floats
) -> Floats:
    """Fit the state to matched dots by Gauss-Newton, in place, and return its covariance, shape (6, 6).

    Args:
        mounted: the rays of n dots and the camera's mount.
        targets: shape (n, 2), matched map dots [m].
        sigmas: shape (n,), standard deviations of the residuals along each axis [m].
        matched: shape (n,), whether each dot is used.
        prior_sigmas: shape (3,), prior standard deviations of scale, roll and pitch [-, rad, rad].
        state: shape (6,), initial state; overwritten with the result.
    """
    normal = np.zeros((STATE_SIZE, STATE_SIZE))
    for _ in range(8):
        normal[:] = 0.0
        gradient = np.zeros(STATE_SIZE)
        for k in range(len(matched)):
            if matched[k]:
                _add_dot(mounted, k, targets[k], sigmas[k], state, normal, gradient)
        for k in range(3):
            weight = 1.0 / (prior_sigmas[k] * prior_sigmas[k])
            normal[3 + k, 3 + k] += weight
            gradient[3 + k] += weight * state[3 + k]
        step = np.linalg.solve(normal, gradient)
        state -= step
        if math.hypot(step[0], step[1]) < 1e-8 and abs(step[2]) < 1e-8:
            break
    return np.linalg.inv(normal).astype(np.float64)


@njit(cache=True)
def _add_dot(
    mounted: MountedRays, k: int, target: Floats, sigma: float, state: Floats, normal: Floats, gradient: Floats
) -> None:
    """Add one dot's residual to the normal equations."""
    jacobian = np.empty((2, STATE_SIZE))
    x, y = project_to_map(mounted, k, state)
    for u in range(STATE_SIZE):
        saved = state[u]
        state[u] = saved + _JACOBIAN_STEP
        ahead_x, ahead_y = project_to_map(mounted, k, state)
        state[u] = saved
        jacobian[0, u] = (ahead_x - x) / _JACOBIAN_STEP
        jacobian[1, u] = (ahead_y - y) / _JACOBIAN_STEP
    weight = 1.0 / (sigma * sigma)
    for u in range(STATE_SIZE):
        gradient[u] += weight * (jacobian[0, u] * (x - target[0]) + jacobian[1, u] * (y - target[1]))
        for w in range(STATE_SIZE):
            normal[u, w] += weight * (jacobian[0, u] * jacobian[0, w] + jacobian[1, u] * jacobian[1, w])


class Refinement(NamedTuple):
    """The fitted pose.

    Attributes:
        state: shape (6,): x, y [m], yaw [rad], scale, roll, pitch [rad].
        covariance: shape (6, 6), covariance of the state.
        matches: shape (n,), index of each dot's map dot in the grid, -1 without a match.
    """

    state: Floats
    covariance: Floats
    matches: Ints


@njit(cache=True)
def refine_pose(grid: DotGrid, mounted: MountedRays, sigmas: Floats, start: Floats, prior_sigmas: Floats) -> Refinement:
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
    if near_count < (1.0 - _UNMATCHED_FRACTION) * _match_dots(grid, mounted, state, tilt_radii, matches, targets):
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
def _is_unchanged(matches: Ints, previous: Ints) -> bool:
    """Return whether all matches equal the previous ones, and copy them to the previous ones."""
    same = True
    for k in range(len(matches)):
        same = same and matches[k] == previous[k]
        previous[k] = matches[k]
    return same


@njit(cache=True)
def _radii_with_tilt(
    grid: DotGrid, mounted: MountedRays, sigmas: Floats, state: Floats, prior_sigmas: Floats
) -> Floats:
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
    grid: DotGrid, mounted: MountedRays, state: Floats, radii: Floats, matches: Ints, targets: Floats
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
def _residual_scale(mounted: MountedRays, state: Floats, matches: Ints, targets: Floats, sigmas: Floats) -> float:
    """Return a lower confidence bound of residuals over standard deviations, from the median (robust to outliers)."""
    ratios = np.empty(len(sigmas))
    count = 0
    for k in range(len(sigmas)):
        if matches[k] >= 0:
            x, y = project_to_map(mounted, k, state)
            ratios[count] = math.hypot(x - targets[k, 0], y - targets[k, 1]) / sigmas[k]
            count += 1
    confidence_factor = 1.0 - _CONFIDENCE_SIGMAS / (_MEDIAN_LENGTH * _MEDIAN_LENGTH * math.sqrt(count))
    return float(confidence_factor * np.median(ratios[:count]) / _MEDIAN_LENGTH)
