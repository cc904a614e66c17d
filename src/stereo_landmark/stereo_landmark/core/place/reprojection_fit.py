"""The displacement that explains best what both cameras see: the default method.

Noise of the present pixels and of the taught points is weighed together, ``S = C + H P H^T``, which to first order is
the adjustment of taught and present images at once. Points that share noise are weighed together. Huber's
loss bounds what a wrong point can do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import wrap_angle
from stereo_landmark.core.place.noise_groups import NoiseGroups, noise_groups
from stereo_landmark.core.place.reprojection_model import PITCH, ROLL, STATES, Reprojection, reproject
from stereo_landmark.core.place.settings import PlaceSettings
from stereo_landmark.core.place.stereo_points import SpatialPoints, StereoPoints
from stereo_landmark.core.place.stereo_rig import MEASURED, StereoRig

STEPS_MAX = 20
STEP_DONE = 1e-7
"""A step smaller than this [m, rad] ends the search."""
HUBER = 3.0
"""Standard deviations of a point beyond which its pull grows no more; four measures have 3.1 or less in 95 %."""
DETERMINANT_MIN = 1e-12
"""Of the information, scaled to a diagonal of ones, below which it does not determine the state."""


@dataclass(frozen=True)
class ReprojectionFit:
    """A fitted state.

    Attributes:
        state: shape (6,), see `reprojection_model`.
        covariance: shape (6, 6), zero where the state is known.
        residuals: shape (n, 4) [px].
        distances: shape (n,), lengths of the residuals in standard deviations; infinite behind the cameras.
    """

    state: NDArray[np.float64]
    covariance: NDArray[np.float64]
    residuals: NDArray[np.float64]
    distances: NDArray[np.float64]


def fit_reprojection(
    seen: StereoPoints,
    taught: SpatialPoints,
    rig: StereoRig,
    start: NDArray[np.float64],
    settings: PlaceSettings,
) -> ReprojectionFit | None:
    """Fit the state by Gauss-Newton steps with weights.

    Args:
        seen: n points.
        taught: the same points in the same order, in the place's frame.
        rig: the cameras.
        start: shape (6,), where to begin; its roll and pitch are the known ones.
        settings: how exactly the calibration and the tilt are known.

    Returns:
        None where the points do not determine the state.
    """
    free = np.arange(STATES) if settings.tilt_sigma > 0.0 else np.arange(ROLL)
    prior = np.zeros((STATES, STATES))
    if settings.tilt_sigma > 0.0:
        prior[[ROLL, PITCH], [ROLL, PITCH]] = settings.tilt_sigma**-2
    groups = noise_groups(
        seen, taught, reproject(start, taught.positions, rig).by_point, settings.pixel_sigma
    )
    state = start.copy()
    for _ in range(STEPS_MAX):
        residuals, jacobian, _ = _whitened(seen, reproject(state, taught.positions, rig), groups)
        information = jacobian.T @ jacobian + prior
        gradient = jacobian.T @ residuals + prior @ (start - state)
        inverse = _inverse(information[np.ix_(free, free)])
        if inverse is None:
            return None
        step = np.zeros(STATES)
        step[free] = inverse @ gradient[free]
        state = state + step
        if np.abs(step).max() < STEP_DONE:
            break
    state[3] = wrap_angle(float(state[3]))
    covariance = np.zeros((STATES, STATES))
    covariance[np.ix_(free, free)] = inverse
    view = reproject(state, taught.positions, rig)
    _, _, distances = _whitened(seen, view, groups)
    return ReprojectionFit(state, covariance, seen.pixels - view.pixels, distances)


def _whitened(
    seen: StereoPoints, view: Reprojection, groups: Sequence[NoiseGroups]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return residuals (4 n,) and derivatives (4 n, 6), both in weighed standard deviations, and distances (n,)."""
    residuals, jacobians, distances = [], [], np.empty(len(seen))
    off = seen.pixels - view.pixels
    for group in groups:
        members = group.members
        spreads = group.spreads(view.by_point)
        blocks = spreads.reshape(*members.shape, MEASURED, *members.shape[1:], MEASURED)
        own = np.linalg.inv(np.linalg.cholesky(np.einsum('gaiaj->gaij', blocks)))
        lengths = np.linalg.norm((own @ off[members][..., None])[..., 0], axis=2)
        distances[members] = np.where(view.in_front[members], lengths, np.inf)
        weights = np.minimum(1.0, HUBER / np.maximum(distances[members], 1e-9))
        # A point that is off takes part as if it were less certain; one behind the cameras does not.
        scale = np.sqrt(weights)[..., None]
        roots = np.linalg.inv(np.linalg.cholesky(spreads))
        residuals.append((roots @ (off[members] * scale).reshape(len(members), -1, 1)).ravel())
        by_state = view.by_state[members] * scale[..., None]
        jacobians.append((roots @ by_state.reshape(len(members), -1, STATES)).reshape(-1, STATES))
    return np.concatenate(residuals), np.concatenate(jacobians), distances


def _inverse(information: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the inverse of a symmetric matrix, None where it has none."""
    diagonal = np.diag(information)
    if not np.isfinite(information).all() or not (diagonal > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(diagonal)
    scaled = information * scale * scale[:, None]
    if np.linalg.det(scaled) < DETERMINANT_MIN:
        return None
    return np.asarray(np.linalg.inv(scaled) * scale * scale[:, None])
