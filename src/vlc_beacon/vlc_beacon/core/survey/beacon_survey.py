"""Position of a lamp by least squares over bearings from known poses, with a consistent covariance.

Errors of consecutive images are correlated: the body sways slowly, and the poses drift. The covariance is therefore the
clustered one, with clusters of one second; constant tilt errors, which residuals do not show, are added.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from shirube_core.geometry import matrix_from_rpy


@dataclass(frozen=True)
class LampBearings:
    """Bearings to one lamp.

    Attributes:
        stamps: stamps, shape (n,), increasing [s].
        positions: camera positions in the map, shape (n, 3) [m].
        rotations: camera rotations ``R_map_camera``, shape (n, 3, 3).
        rays: x and y of the undistorted rays with z = 1 in the optical frame, shape (n, 2).
        sigmas: standard deviation of the rays along each axis, shape (n,).
    """

    stamps: NDArray[np.float64]
    positions: NDArray[np.float64]
    rotations: NDArray[np.float64]
    rays: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of bearings."""
        return len(self.stamps)

    def subset(self, mask: NDArray[np.bool_]) -> LampBearings:
        """Return the bearings selected by a mask, shape (n,)."""
        return LampBearings(
            self.stamps[mask], self.positions[mask], self.rotations[mask], self.rays[mask], self.sigmas[mask]
        )


CLUSTER = 1.0
"""Duration of a cluster [s]."""
CLUSTERS_MIN = 4
OUTLIER_SIGMAS = 6.0
"""Outlier threshold [standard deviations of the residuals]."""
MAD_TO_SIGMA = 1.4826
PARALLAX_MIN = 0.05
"""Minimum parallax [rad]; below it the height is undetermined."""
SIGMA_MAX = 0.1
"""Maximum standard deviation of a surveyed lamp [m]."""
_TILT_STEP = 1e-6


@dataclass(frozen=True)
class SurveyedLamp:
    """A lamp whose position was surveyed.

    Attributes:
        xyz: position of its centre in the map frame [m].
        sigma: standard deviations along x, y and z, shape (3,) [m].
        observations: number of bearings used.
    """

    xyz: tuple[float, float, float]
    sigma: NDArray[np.float64]
    observations: int


@dataclass(frozen=True)
class NotSurveyed:
    """A lamp whose position was not surveyed: cause and remedy."""

    reason: str


def survey_lamp(bearings: LampBearings, tilt_sigma: float) -> SurveyedLamp | NotSurveyed:
    """Triangulate a lamp from bearings with possible outliers; ``tilt_sigma`` is of the constant tilt error [rad]."""
    if len(_clusters(bearings)[0]) < CLUSTERS_MIN:
        return NotSurveyed(f'it was in view for less than {CLUSTERS_MIN * CLUSTER:g} s; drive on longer')
    start = _triangulate(bearings)
    solved = least_squares(_residuals, start, args=(bearings,), loss='soft_l1')
    errors = np.abs(_residuals(solved.x, bearings)).reshape(-1, 2).max(axis=1)
    scale = max(1.0, MAD_TO_SIGMA * float(np.median(errors)))
    inliers = bearings.subset(errors <= OUTLIER_SIGMAS * scale)
    if len(_clusters(inliers)[0]) < CLUSTERS_MIN:
        return NotSurveyed('its bearings are inconsistent; check the poses and the camera mount')
    solved = least_squares(_residuals, solved.x, args=(inliers,))
    position = np.asarray(solved.x, dtype=np.float64)
    if _parallax(position, inliers) < PARALLAX_MIN:
        return NotSurveyed('it was seen from one direction only; drive past it')
    jacobian, residuals = np.asarray(solved.jac), np.asarray(solved.fun)
    covariance = _clustered_covariance(inliers, jacobian, residuals)
    shifts = _tilt_sensitivity(position, inliers, jacobian, residuals)
    sigma = np.sqrt(np.diag(covariance + tilt_sigma**2 * shifts @ shifts.T))
    if sigma.max() > SIGMA_MAX:
        detail = f'its standard deviation is {sigma.max():.1g} m'
        return NotSurveyed(f'{detail}; check the poses and the camera mount')
    x, y, z = position.tolist()
    return SurveyedLamp((x, y, z), sigma, len(inliers))


def _tilt_sensitivity(
    position: NDArray[np.float64], bearings: LampBearings, jacobian: NDArray[np.float64], residuals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the sensitivity to constant errors about the camera's x and y axes, shape (3, 2) [m/rad]."""
    columns = []
    for axis in np.eye(3)[:2]:
        tilted = replace(bearings, rotations=bearings.rotations @ matrix_from_rpy(_TILT_STEP * axis))
        columns.append((_residuals(position, tilted) - residuals) / _TILT_STEP)
    return np.asarray(np.linalg.lstsq(jacobian, -np.column_stack(columns), rcond=None)[0])


def _residuals(position: NDArray[np.float64], bearings: LampBearings) -> NDArray[np.float64]:
    """Return predicted minus measured rays over their sigmas, shape (2 n,)."""
    points = np.einsum('nji,nj->ni', bearings.rotations, position - bearings.positions)
    rays = points[:, :2] / np.maximum(points[:, 2:], 1e-3)
    return np.asarray(((rays - bearings.rays) / bearings.sigmas[:, None]).ravel())


def _triangulate(bearings: LampBearings) -> NDArray[np.float64]:
    """Return the point nearest to all lines of sight, shape (3,)."""
    rays = np.column_stack([bearings.rays, np.ones(len(bearings))])
    ahead = np.einsum('nij,nj->ni', bearings.rotations, rays)
    directions = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    projectors = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    right_side = np.einsum('nij,nj->i', projectors, bearings.positions)
    return np.asarray(np.linalg.lstsq(projectors.sum(axis=0), right_side, rcond=None)[0])


def _parallax(position: NDArray[np.float64], bearings: LampBearings) -> float:
    """Return the parallax: twice the largest angle between a bearing and the mean bearing [rad]."""
    ahead = position - bearings.positions
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    mean = ahead.mean(axis=0) / np.linalg.norm(ahead.mean(axis=0))
    return float(2.0 * np.arccos(np.clip(ahead @ mean, -1.0, 1.0)).max())


def _clusters(bearings: LampBearings) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the IDs of the clusters, and the cluster index of each bearing."""
    numbers, cluster_indices = np.unique(np.floor(bearings.stamps / CLUSTER), return_inverse=True)
    return numbers, np.asarray(cluster_indices, dtype=np.int64)


def _clustered_covariance(
    bearings: LampBearings, jacobian: NDArray[np.float64], residuals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariance of the position, shape (3, 3) [m^2], for errors correlated within clusters."""
    numbers, cluster_indices = _clusters(bearings)
    scores = np.zeros((len(numbers), 3))
    np.add.at(scores, np.repeat(cluster_indices, 2), jacobian * residuals[:, None])
    bread = np.linalg.inv(jacobian.T @ jacobian)
    return np.asarray(len(numbers) / (len(numbers) - 3) * bread @ (scores.T @ scores) @ bread)
