"""Estimates the displacement of the robot from the points of taught targets (paper 3.1 and 3.4)."""

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from shirube_core.geometry import SE2, wrap_angle
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.place.joint_fit import ReprojectionFit, fit_reprojection, reproject
from stereo_landmark.core.place.point_registration import (
    closed_form,
    closed_form_covariance,
    consistent_points,
    find_consensus_set,
)
from stereo_landmark.core.settings import CLOSED_FORM, PlaceSettings
from stereo_landmark.core.stereo import (
    SpatialPoints,
    StereoPoints,
    StereoRig,
    TiltedCameras,
    add_calibration_noise,
    is_in_same_row,
    is_measurable,
)


@dataclass(frozen=True)
class PlaceFix:
    """Pose of the robot in the frame of a taught place, which is the gravity-aligned base frame at teaching time.

    Attributes:
        T_place_base: pose of the robot in the frame of the place.
        height: height of the base above the taught pose [m].
        tilt: estimated roll and pitch of the base [rad].
        covariance: covariance of x, y, z [m] and yaw [rad], shape (4, 4).
        names: names of the inlier points of shapes.
        residuals: reprojection residuals of these points and of the features, u, v left and u, v right, shape (n, 4)
            [px].
        feature_count: number of features of the taught view in the fit.
    """

    T_place_base: SE2
    height: float
    tilt: tuple[float, float]
    covariance: Floats
    names: tuple[str, ...]
    residuals: Floats
    feature_count: int = 0

    @property
    def position_sigma(self) -> float:
        """Standard deviation of the position in its worst direction [m]."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance[:2, :2])[-1]))

    @property
    def yaw_sigma(self) -> float:
        """Standard deviation of the yaw [rad]."""
        return math.sqrt(float(self.covariance[3, 3]))


class NoPlaceFixReason(Enum):
    """Why there is no displacement."""

    TOO_FEW_POINTS = 'too few points'
    ROW_MISMATCH = 'left and right show the points in different rows; calibrate the cameras as a pair'
    INCONSISTENT = 'the distances between the points are not the taught ones'
    POOR_GEOMETRY = 'the points do not determine the displacement'
    UNCERTAIN = 'the displacement is too uncertain'


@dataclass(frozen=True)
class NoPlaceFix:
    """No displacement, and why.

    Attributes:
        reason: the kind of failure.
        detail: numbers for the diagnostics.
    """

    reason: NoPlaceFixReason
    detail: str


CONFIRMED_POINTS_MIN = 3
"""Minimum number of points left when others are outliers: two points of a wrong match may be at the right distance."""
RUNNER_UP_RATIO = 0.7
"""A runner-up hypothesis with at least this fraction of the best support makes the displacement ambiguous."""
_TILT_STEP = 1e-5
"""Step of the numerical derivatives [rad]."""


class PlaceLocator:
    """Estimates the robot's displacement from a taught pose.

    Args:
        rig: stereo cameras.
        settings: estimation settings; None for the defaults.
    """

    def __init__(self, rig: StereoRig, settings: PlaceSettings | None = None) -> None:
        self._rig = rig
        self._settings = settings or PlaceSettings()

    def spatial_points(self, observed: StereoPoints, tilt: tuple[float, float] = (0.0, 0.0)) -> SpatialPoints:
        """Triangulate points into the gravity-aligned base frame, as they are taught.

        Args:
            observed: points with a measurable disparity.
            tilt: roll and pitch of the base [rad].
        """
        return TiltedCameras(self._rig, tilt).spatial_points(observed)

    def locate(
        self, observed: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float] = (0.0, 0.0)
    ) -> PlaceFix | NoPlaceFix:
        """Estimate the displacement.

        Args:
            observed: points of the targets in the current stereo pair.
            taught: points of the place in its frame; points that are only in one of both sets are ignored.
            tilt: known roll and pitch of the base [rad].
        """
        # Corresponding points that both cameras measure (3.3d).
        known = np.array([name in taught.names for name in observed.names], dtype=np.bool_)
        observed = observed.subset(known & is_measurable(observed, self._rig))
        needed = self._settings.points_min
        if len(observed) < needed:
            detail = f'{len(observed)} taught points are visible in both cameras, at least {needed} are needed'
            return NoPlaceFix(NoPlaceFixReason.TOO_FEW_POINTS, detail)
        # Two points are enough (3.1) if there are no others; of more points, a third one must confirm them.
        needed = max(needed, min(len(observed), CONFIRMED_POINTS_MIN))
        # Rectified images show a point in the same row; other points are mismatched.
        in_same_row = is_in_same_row(observed, self._settings.pixel_sigma)
        if in_same_row.sum() < needed:
            dv = float(np.median(observed.pixels[:, 3] - observed.pixels[:, 1]))
            detail = (
                f'{int(in_same_row.sum())} of {len(observed)} points are in the same row of both images; '
                f'in the right one they are {abs(dv):.2f} px {"lower" if dv > 0.0 else "higher"} (median)'
            )
            return NoPlaceFix(NoPlaceFixReason.ROW_MISMATCH, detail)
        observed = observed.subset(in_same_row)
        # 3D coordinates at the current pose (3.4).
        found = self.spatial_points(observed, tilt)
        # Points at inconsistent distances are excluded (3.4, end).
        inliers = self._select_inliers(observed, found, taught.select(observed.names), needed)
        if isinstance(inliers, NoPlaceFix):
            return inliers
        # The displacement from the remaining points (3.1).
        names = inliers.names
        return self._fit_displacement(inliers, found.select(names), taught.select(names), tilt, needed)

    def _select_inliers(
        self, observed: StereoPoints, found: SpatialPoints, taught: SpatialPoints, needed: int
    ) -> StereoPoints | NoPlaceFix:
        """Return the inliers: points in the consensus set whose pairwise distances are consistent."""
        consensus = find_consensus_set(found, taught, self._settings.tilt_sigma)
        kept = consensus.inliers if consensus.inliers.any() else np.ones(len(observed), dtype=np.bool_)
        rest = observed.subset(~kept)
        if len(rest) >= needed:
            runner_up = find_consensus_set(
                found.select(rest.names), taught.select(rest.names), self._settings.tilt_sigma
            )
            if runner_up.support > RUNNER_UP_RATIO * consensus.support:
                detail = f'{int(consensus.inliers.sum())} and {int(runner_up.inliers.sum())} points fit different poses'
                return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, detail)
        observed = observed.subset(kept)
        kept = consistent_points(found.select(observed.names), taught.select(observed.names))
        if kept.sum() < needed:
            detail = f'{int(kept.sum())} of {len(found)} points have consistent distances'
            return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, detail)
        return observed.subset(kept)

    def _fit_displacement(
        self,
        observed: StereoPoints,
        found: SpatialPoints,
        taught: SpatialPoints,
        tilt: tuple[float, float],
        needed: int,
    ) -> PlaceFix | NoPlaceFix:
        if self._settings.method == CLOSED_FORM:
            return self._fit_closed_form(observed, taught, tilt)
        # The closed form (3.1) is the initial value of the reprojection fit (not in the paper).
        initial = closed_form(found.positions, taught.positions)
        if initial is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, 'the points are on one vertical line')
        state = np.array([*initial.state, *tilt])
        fit = fit_reprojection(observed, taught, self._rig, state, self._settings)
        # The worst outlier is excluded until all points fit.
        while fit is not None and fit.mahalanobis_distances.max() > self._settings.gate_sigmas:
            if len(observed) <= needed:
                return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, _describe_outlier(observed, fit))
            kept = np.arange(len(observed)) != np.argmax(fit.mahalanobis_distances)
            observed = observed.subset(kept)
            taught = taught.select(observed.names)
            fit = fit_reprojection(observed, taught, self._rig, state, self._settings)
        if fit is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, f'{len(observed)} points')
        return self._check_uncertainty(_make_fix(fit.state, fit.covariance[:4, :4], fit.residuals, observed))

    def _fit_closed_form(
        self, observed: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float]
    ) -> PlaceFix | NoPlaceFix:
        noisy = add_calibration_noise(observed, self._settings.pixel_sigma)
        found = self.spatial_points(noisy, tilt)
        displacement = closed_form(found.positions, taught.positions)
        if displacement is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, 'the points are on one vertical line')
        state = np.array([*displacement.state, *tilt])
        residuals = observed.pixels - reproject(state, taught.positions, self._rig).pixels
        tilt_jacobian = self._tilt_jacobian(noisy, taught, tilt)
        covariance = closed_form_covariance(found, taught)
        covariance += self._settings.tilt_sigma**2 * tilt_jacobian @ tilt_jacobian.T
        return self._check_uncertainty(_make_fix(state, covariance, residuals, observed))

    def _tilt_jacobian(self, observed: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float]) -> Floats:
        """Return the derivatives of the closed form's x, y, z and yaw by roll and pitch, shape (4, 2)."""
        columns = []
        for axis in np.eye(2):
            states = []
            for step in (-_TILT_STEP, _TILT_STEP):
                roll, pitch = np.array(tilt) + step * axis
                moved = closed_form(self.spatial_points(observed, (roll, pitch)).positions, taught.positions)
                states.append(np.full(4, np.inf) if moved is None else moved.state)
            change = states[1] - states[0]
            columns.append([*change[:3], wrap_angle(float(change[3]))])
        return np.array(columns).T / (2.0 * _TILT_STEP)

    def _check_uncertainty(self, fix: PlaceFix) -> PlaceFix | NoPlaceFix:
        if fix.position_sigma > self._settings.position_sigma_max:
            return NoPlaceFix(NoPlaceFixReason.UNCERTAIN, f'standard deviation {fix.position_sigma:.3f} m')
        return fix


def _make_fix(state: Floats, covariance: Floats, residuals: Floats, observed: StereoPoints) -> PlaceFix:
    return PlaceFix(
        SE2(float(state[0]), float(state[1]), float(state[3])),
        float(state[2]),
        (float(state[4]), float(state[5])),
        covariance,
        observed.names,
        residuals,
    )


def _describe_outlier(observed: StereoPoints, fit: ReprojectionFit) -> str:
    name = observed.names[int(np.argmax(fit.mahalanobis_distances))]
    return f'point {name} is {fit.mahalanobis_distances.max():.0f} standard deviations away from its prediction'
