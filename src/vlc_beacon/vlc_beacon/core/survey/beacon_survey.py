"""Position of a lamp by least squares over bearings from known poses, with a consistent covariance.

Errors of consecutive images are correlated: the body sways slowly, and the poses drift. The covariance is therefore the
clustered one, with clusters of one second; constant tilt errors, which residuals do not show, are added.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from vlc_beacon.core.pose.lamp_rays import lamp_rays
from vlc_beacon.core.receiver.light_receiver import LampObservation, LightReceiver
from vlc_beacon.core.settings import ReceiverSettings


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
        return len(self.stamps)

    def subset(self, mask: NDArray[np.bool_]) -> LampBearings:
        """Return the bearings selected by a mask, shape (n,)."""
        return LampBearings(*(getattr(self, each.name)[mask] for each in fields(self)))


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


PIXEL_SIGMA = 0.1
"""Standard deviation of the camera calibration, in addition to that of the centres [px]."""
_Observation = tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]
_CameraPose = tuple[float, NDArray[np.float64], NDArray[np.float64]]


def image_rotation(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """Return the image rotation from u to v [rad] between two ``R_map_camera``, each of shape (3, 3)."""
    change = after.T @ before
    return math.atan2(change[1, 0], change[0, 0])


class BearingCollector:
    """Tracks the lamps over a drive."""

    def __init__(self, camera: PinholeCamera, settings: ReceiverSettings) -> None:
        self._camera = camera
        self._row_time = settings.row_time if settings.is_rolling else 0.0
        # Without a beacons file all IDs are unknown IDs.
        self._light = LightReceiver([], settings)
        self._beacons: dict[int, int] = {}
        self._observations: defaultdict[int, list[_Observation]] = defaultdict(list)
        self._last: _CameraPose | None = None

    def add(
        self, stamp: float, image: NDArray[np.uint8], position: NDArray[np.float64], rotation: NDArray[np.float64]
    ) -> None:
        """Process a grey image, later than the last one, with the camera's position and rotation in the map."""
        now = stamp, position, rotation
        before, self._last = self._last or now, now
        for lamp in self._light.receive(stamp, image, image_rotation(before[2], rotation)):
            if lamp.unknown_id is not None:
                self._beacons[lamp.sample.key] = lamp.unknown_id
            if lamp.sample.is_lit:
                self._observations[lamp.sample.key].append(self._observe(lamp, before, now))

    def bearings(self) -> dict[int, LampBearings]:
        """Return the bearings of each lamp with a confirmed ID, by ID."""
        by_beacon: defaultdict[int, list[_Observation]] = defaultdict(list)
        for key, beacon in self._beacons.items():
            by_beacon[beacon] += self._observations[key]
        return {beacon: self._make_bearings(observations) for beacon, observations in sorted(by_beacon.items())}

    def _observe(self, lamp: LampObservation, before: _CameraPose, now: _CameraPose) -> _Observation:
        """Return the observation with the camera pose at the exposure of its row."""
        centre = lamp.sample.centre
        sigma = float(np.hypot(lamp.sample.sigma.max(), PIXEL_SIGMA))
        stamp, position, rotation = _extrapolate(before, now, self._row_time * float(centre[1]))
        return stamp, position, rotation, centre, sigma

    def _make_bearings(self, observations: list[_Observation]) -> LampBearings:
        observations.sort(key=lambda observation: observation[0])
        stamps, positions, rotations, centres, sigmas = zip(*observations, strict=True)
        rays = lamp_rays(self._camera, np.zeros(len(centres), dtype=np.int64), np.array(centres), np.array(sigmas))
        variances = 0.5 * np.trace(rays.covariances(0.0), axis1=1, axis2=2)
        bearings = LampBearings(
            np.array(stamps), np.array(positions), np.array(rotations), rays.rays, np.sqrt(variances)
        )
        return bearings.subset(rays.is_valid)


def _extrapolate(before: _CameraPose, now: _CameraPose, delay: float) -> _CameraPose:
    """Extrapolate the camera pose by ``delay`` [s] after ``now`` with constant velocity."""
    stamp, position, rotation = now
    step = stamp - before[0]
    if delay == 0.0 or step <= 0.0:
        return now
    fraction = delay / step
    turn = Rotation.from_matrix(before[2].T @ rotation).as_rotvec()
    rotation_step = Rotation.from_rotvec(fraction * turn).as_matrix()
    return stamp + delay, position + fraction * (position - before[1]), rotation @ rotation_step
