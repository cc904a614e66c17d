"""Estimates the robot's displacement from the points of taught targets (paper 3.1 and 3.4)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose, level_camera, wrap_angle
from stereo_landmark.core.place.closed_form import closed_form, closed_form_covariance
from stereo_landmark.core.place.consensus import largest_consensus
from stereo_landmark.core.place.consistency import consistent_points
from stereo_landmark.core.place.place_fix import NoPlaceFix, NoPlaceFixReason, PlaceFix
from stereo_landmark.core.place.reprojection_fit import ReprojectionFit, fit_reprojection
from stereo_landmark.core.place.reprojection_model import reproject
from stereo_landmark.core.place.settings import CLOSED_FORM, PlaceSettings
from stereo_landmark.core.place.stereo_points import (
    SpatialPoints,
    StereoPoints,
    measurable,
    rows_agree,
    triangulate,
    with_calibration_error,
)
from stereo_landmark.core.place.stereo_rig import StereoRig

RIVAL_SHARE = 0.7
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

    def spatial_points(self, seen: StereoPoints, tilt: tuple[float, float] = (0.0, 0.0)) -> SpatialPoints:
        """Triangulate points into the gravity-aligned base frame, as they are taught.

        Args:
            seen: points with a measurable disparity.
            tilt: roll and pitch of the base [rad].
        """
        camera = level_camera(self._rig.mount, *tilt)
        return triangulate(seen, self._rig).moved(camera.rotation, camera.position)

    def locate(
        self, seen: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float] = (0.0, 0.0)
    ) -> PlaceFix | NoPlaceFix:
        """Estimate the displacement.

        Args:
            seen: points of the targets in the current stereo pair.
            taught: points of the place in its frame; points that are only in one of both sets are ignored.
            tilt: known roll and pitch of the base [rad].
        """
        known = np.array([name in taught.names for name in seen.names], dtype=np.bool_)
        seen = seen.subset(known & measurable(seen, self._rig))
        if len(seen) < self._settings.points_min:
            return self._too_few(len(seen))
        in_rows = rows_agree(seen, self._settings.pixel_sigma)
        if in_rows.sum() < self._settings.points_min:
            apart = float(np.median(seen.pixels[:, 3] - seen.pixels[:, 1]))
            detail = (
                f'{int(in_rows.sum())} of {len(seen)} points are in the same row of both images; '
                f'in the right one they are {abs(apart):.2f} px {"lower" if apart > 0.0 else "higher"} (median)'
            )
            return NoPlaceFix(NoPlaceFixReason.ROWS_APART, detail)
        seen = seen.subset(in_rows)
        found = self.spatial_points(seen, tilt)
        agreeing = self._agreeing(seen, found, taught.selected(seen.names))
        if isinstance(agreeing, NoPlaceFix):
            return agreeing
        names = agreeing.names
        return self._displacement(agreeing, found.selected(names), taught.selected(names), tilt)

    def _agreeing(
        self, seen: StereoPoints, found: SpatialPoints, taught: SpatialPoints
    ) -> StereoPoints | NoPlaceFix:
        """Return the inliers: points in the consensus set whose pairwise distances are consistent."""
        vote = largest_consensus(found, taught, self._settings.tilt_sigma)
        kept = vote.agreeing if vote.agreeing.any() else np.ones(len(seen), dtype=np.bool_)
        rest = seen.subset(~kept)
        if len(rest) >= self._settings.points_min:
            rival = largest_consensus(
                found.selected(rest.names), taught.selected(rest.names), self._settings.tilt_sigma
            )
            if rival.votes > RIVAL_SHARE * vote.votes:
                detail = (
                    f'{int(vote.agreeing.sum())} and {int(rival.agreeing.sum())} points fit different poses'
                )
                return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, detail)
        seen = seen.subset(kept)
        kept = consistent_points(found.selected(seen.names), taught.selected(seen.names))
        if kept.sum() < self._settings.points_min:
            detail = f'{int(kept.sum())} of {len(found)} points have consistent distances'
            return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, detail)
        return seen.subset(kept)

    def _displacement(
        self, seen: StereoPoints, found: SpatialPoints, taught: SpatialPoints, tilt: tuple[float, float]
    ) -> PlaceFix | NoPlaceFix:
        first = closed_form(found.positions, taught.positions)
        if first is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, 'the points are on one vertical line')
        state = np.array([*first.state, *tilt])
        fit = fit_reprojection(seen, taught, self._rig, state, self._settings)
        while fit is not None and fit.distances.max() > self._settings.gate_sigmas:
            if len(seen) <= self._settings.points_min:
                return NoPlaceFix(NoPlaceFixReason.INCONSISTENT, _farthest(seen, fit))
            kept = np.arange(len(seen)) != np.argmax(fit.distances)
            seen = seen.subset(kept)
            taught = taught.selected(seen.names)
            fit = fit_reprojection(seen, taught, self._rig, state, self._settings)
        if fit is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, f'{len(seen)} points')
        if self._settings.method == CLOSED_FORM:
            return self._by_closed_form(seen, taught, tilt)
        return self._certain(_fix(fit.state, fit.covariance[:4, :4], fit.residuals, seen))

    def _by_closed_form(
        self, seen: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float]
    ) -> PlaceFix | NoPlaceFix:
        noisy = with_calibration_error(seen, self._settings.pixel_sigma)
        found = self.spatial_points(noisy, tilt)
        displacement = closed_form(found.positions, taught.positions)
        if displacement is None:
            return NoPlaceFix(NoPlaceFixReason.POOR_GEOMETRY, 'the points are on one vertical line')
        state = np.array([*displacement.state, *tilt])
        residuals = seen.pixels - reproject(state, taught.positions, self._rig).pixels
        by_tilt = self._change_with_tilt(noisy, taught, tilt)
        covariance = closed_form_covariance(found, taught)
        covariance += self._settings.tilt_sigma**2 * by_tilt @ by_tilt.T
        return self._certain(_fix(state, covariance, residuals, seen))

    def _change_with_tilt(
        self, seen: StereoPoints, taught: SpatialPoints, tilt: tuple[float, float]
    ) -> NDArray[np.float64]:
        """Return the derivatives of the closed form's x, y, z and yaw by roll and pitch, shape (4, 2)."""
        changes = []
        for axis in np.eye(2):
            states = []
            for step in (-_TILT_STEP, _TILT_STEP):
                roll, pitch = np.array(tilt) + step * axis
                moved = closed_form(self.spatial_points(seen, (roll, pitch)).positions, taught.positions)
                states.append(np.full(4, np.inf) if moved is None else moved.state)
            change = states[1] - states[0]
            changes.append([*change[:3], wrap_angle(float(change[3]))])
        return np.array(changes).T / (2.0 * _TILT_STEP)

    def _certain(self, fix: PlaceFix) -> PlaceFix | NoPlaceFix:
        sigma = math.sqrt(float(np.linalg.eigvalsh(fix.covariance[:2, :2])[-1]))
        if sigma > self._settings.position_sigma_max:
            return NoPlaceFix(NoPlaceFixReason.UNCERTAIN, f'standard deviation {sigma:.3f} m')
        return fix

    def _too_few(self, count: int) -> NoPlaceFix:
        detail = f'{count} taught points are visible in both cameras, at least {self._settings.points_min} are needed'
        return NoPlaceFix(NoPlaceFixReason.TOO_FEW_POINTS, detail)


def _fix(
    state: NDArray[np.float64],
    covariance: NDArray[np.float64],
    residuals: NDArray[np.float64],
    seen: StereoPoints,
) -> PlaceFix:
    return PlaceFix(
        PlanarPose(float(state[0]), float(state[1]), float(state[3])),
        float(state[2]),
        (float(state[4]), float(state[5])),
        covariance,
        seen.names,
        residuals,
    )


def _farthest(seen: StereoPoints, fit: ReprojectionFit) -> str:
    name = seen.names[int(np.argmax(fit.distances))]
    return f'point {name} is {fit.distances.max():.0f} standard deviations away from its prediction'
