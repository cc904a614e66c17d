"""The place of a lamp by least squares over many bearings from known poses, with an honest sigma.

Errors of neighbouring images are alike: the body sways slowly, and the poses drift. So the covariance is that of
clusters, of one second each, and errors of the tilt that never change are added: no residual shows them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from shirube_geometry import matrix_from_rpy
from vlc_beacon.core.survey.lamp_bearings import LampBearings

CLUSTER = 1.0
"""[s]"""
CLUSTERS_MIN = 4
OUTLIER_SIGMAS = 6.0
"""In standard deviations of the residuals."""
MAD_TO_SIGMA = 1.4826
PARALLAX_MIN = 0.05
"""Least largest angle between two bearings [rad]: with less the height is a guess."""
SIGMA_MAX = 0.1
"""A lamp that is less sure is not told [m]."""
_TILT_STEP = 1e-6


@dataclass(frozen=True)
class SurveyedLamp:
    """A lamp whose place was found.

    Attributes:
        xyz: its centre in the map frame [m].
        sigma: shape (3,), standard deviations along x, y and z [m].
        sightings: how many bearings were used.
    """

    xyz: tuple[float, float, float]
    sigma: NDArray[np.float64]
    sightings: int


@dataclass(frozen=True)
class NotSurveyed:
    """A lamp whose place was not found.

    Attributes:
        reason: why, and what to do.
    """

    reason: str


def survey_lamp(bearings: LampBearings, tilt_sigma: float) -> SurveyedLamp | NotSurveyed:
    """Return where a lamp hangs.

    Args:
        bearings: of the lamp; some may be of another.
        tilt_sigma: standard deviation of the constant error of roll and pitch [rad].
    """
    if len(_clusters(bearings)[0]) < CLUSTERS_MIN:
        return NotSurveyed(f'it was in view for less than {CLUSTERS_MIN * CLUSTER:g} s; drive on longer')
    start = _meeting_point(bearings)
    solved = least_squares(_residuals, start, args=(bearings,), loss='soft_l1')
    errors = np.abs(_residuals(solved.x, bearings)).reshape(-1, 2).max(axis=1)
    scale = max(1.0, MAD_TO_SIGMA * float(np.median(errors)))
    kept = bearings.subset(errors <= OUTLIER_SIGMAS * scale)
    if len(_clusters(kept)[0]) < CLUSTERS_MIN:
        return NotSurveyed('its bearings contradict each other; check the poses and the mount of the camera')
    solved = least_squares(_residuals, solved.x, args=(kept,))
    place = np.asarray(solved.x, dtype=np.float64)
    if _parallax(place, kept) < PARALLAX_MIN:
        return NotSurveyed('it was seen from one direction only; drive past it')
    jacobian, residuals = np.asarray(solved.jac), np.asarray(solved.fun)
    covariance = _clustered_covariance(kept, jacobian, residuals)
    shifts = _shifts_by_tilt(place, kept, jacobian, residuals)
    sigma = np.sqrt(np.diag(covariance + tilt_sigma**2 * shifts @ shifts.T))
    if sigma.max() > SIGMA_MAX:
        return NotSurveyed(
            f'its place is unsure by {sigma.max():.1g} m; check the poses and the mount of the camera'
        )
    x, y, z = place.tolist()
    return SurveyedLamp((x, y, z), sigma, len(kept))


def _shifts_by_tilt(
    place: NDArray[np.float64],
    bearings: LampBearings,
    jacobian: NDArray[np.float64],
    residuals: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return how the place moves with a constant error about the camera's x and y axes, shape (3, 2) [m/rad]."""
    columns = []
    for axis in np.eye(3)[:2]:
        rotations = bearings.rotations @ matrix_from_rpy(_TILT_STEP * axis)
        columns.append((_residuals(place, replace(bearings, rotations=rotations)) - residuals) / _TILT_STEP)
    return np.asarray(np.linalg.lstsq(jacobian, -np.column_stack(columns), rcond=None)[0])


def _residuals(place: NDArray[np.float64], bearings: LampBearings) -> NDArray[np.float64]:
    """Return expected minus seen rays over their sigmas, shape (2 n,)."""
    points = np.einsum('nji,nj->ni', bearings.rotations, place - bearings.positions)
    rays = points[:, :2] / np.maximum(points[:, 2:], 1e-3)
    return np.asarray(((rays - bearings.rays) / bearings.sigmas[:, None]).ravel())


def _directions(bearings: LampBearings) -> NDArray[np.float64]:
    """Return unit vectors towards the lamp in the map, shape (n, 3)."""
    rays = np.column_stack([bearings.rays, np.ones(len(bearings))])
    ahead = np.einsum('nij,nj->ni', bearings.rotations, rays)
    return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True))


def _meeting_point(bearings: LampBearings) -> NDArray[np.float64]:
    """Return the point that is nearest to all lines of sight, shape (3,)."""
    directions = _directions(bearings)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    wanted = np.einsum('nij,nj->i', across, bearings.positions)
    return np.asarray(np.linalg.lstsq(across.sum(axis=0), wanted, rcond=None)[0])


def _parallax(place: NDArray[np.float64], bearings: LampBearings) -> float:
    """Return the angle between the bearings that differ most from the mean, twice the largest of them [rad]."""
    ahead = place - bearings.positions
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    mean = ahead.mean(axis=0) / np.linalg.norm(ahead.mean(axis=0))
    return float(2.0 * np.arccos(np.clip(ahead @ mean, -1.0, 1.0)).max())


def _clusters(bearings: LampBearings) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the numbers of the clusters that hold bearings, and the place of each bearing's cluster among them."""
    numbers, owners = np.unique(np.floor(bearings.stamps / CLUSTER), return_inverse=True)
    return numbers, np.asarray(owners, dtype=np.int64)


def _clustered_covariance(
    bearings: LampBearings, jacobian: NDArray[np.float64], residuals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance of the place, shape (3, 3) [m^2], with errors alike within each cluster."""
    numbers, owners = _clusters(bearings)
    pulls = np.zeros((len(numbers), 3))
    np.add.at(pulls, np.repeat(owners, 2), jacobian * residuals[:, None])
    bread = np.linalg.inv(jacobian.T @ jacobian)
    return np.asarray(len(numbers) / (len(numbers) - 3) * bread @ (pulls.T @ pulls) @ bread)
