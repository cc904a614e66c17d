"""Consensus of a subset of the lamps, used when no pose explains all of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import LevelCamera
from vlc_beacon.core.pose.bearing_model import camera_points
from vlc_beacon.core.pose.pose_fix import ExpectedPose
from vlc_beacon.core.pose.pose_least_squares import PoseEstimate, PoseLeastSquares

ROUNDS = 3
LOOSE = 3.0
"""Factor on the gate of a pose from two lamps, which predicts other lamps less accurately."""
SAME_WITHIN = 0.005
"""Poses whose components differ by less are equal [m, rad]."""


@dataclass(frozen=True)
class Agreement:
    """A pose and its consensus set.

    Attributes:
        fit: pose fitted to the inliers.
        own: mask of the inliers, observations of lamps at their own positions, each lamp once, shape (n,).
        place: index of the other lamp at whose position an observation is, -1 for none, shape (n,).
    """

    fit: PoseEstimate
    own: NDArray[np.bool_]
    place: NDArray[np.int64]

    @property
    def swapped(self) -> NDArray[np.bool_]:
        """Mask of observations of lamps at the positions of others, shape (n,)."""
        return self.place >= 0

    @property
    def score(self) -> int:
        """Number of observations at the position of a known lamp."""
        return int(self.own.sum() + self.swapped.sum())


def best_agreements(
    squares: PoseLeastSquares,
    starts: Iterable[NDArray[np.float64]],
    places: NDArray[np.float64],
    camera: LevelCamera,
    gate: float,
) -> list[Agreement]:
    """Return the distinct consensus sets, those with most lamps first.

    Args:
        squares: least-squares problem of the observations.
        starts: initial states, each of shape (6,).
        places: positions of all known lamps in the map frame, shape (m, 3) [m].
        camera: gravity-aligned camera pose on the robot.
        gate: maximum residual of an inlier [standard deviations].
    """
    agreements: list[Agreement] = []
    for start in starts:
        fitted = _fit_of_agreeing(squares, start, gate)
        if fitted is None:
            continue
        fit, own = fitted
        if any(fit.is_within(SAME_WITHIN, known.fit) for known in agreements):
            continue
        place = _other_places(squares, fit, own, places, camera, gate)
        agreements.append(Agreement(fit, own, place))
    agreements.sort(key=lambda agreement: (-agreement.score, -int(agreement.own.sum())))
    return agreements


def chosen_agreement(
    agreements: list[Agreement], unknowns: int, expected: ExpectedPose | None, within: float
) -> Agreement | None:
    """Select a reliable consensus set, or return None.

    It must contain more lamps than the minimum for a pose, and no other set may have as many; otherwise the only set
    consistent with the expected pose is used.

    Args:
        agreements: consensus sets, sorted by size.
        unknowns: number of unknowns of the pose.
        expected: expected pose, None if unknown.
        within: maximum distance from the expected pose [standard deviations].
    """
    if not agreements:
        return None
    tops = [agreement for agreement in agreements if agreement.score == agreements[0].score]
    if len(tops) == 1 and 2 * tops[0].score > unknowns:
        return tops[0]
    if expected is None:
        return None
    near = [agreement for agreement in tops if agreement.fit.distance_from(expected) < within]
    return near[0] if len(near) == 1 else None


def _fit_of_agreeing(
    squares: PoseLeastSquares, state: NDArray[np.float64], gate: float
) -> tuple[PoseEstimate, NDArray[np.bool_]] | None:
    """Fit iteratively to the inliers; return the fit and the mask of the inliers."""
    own = _nearest_of_each(squares, squares.evaluate(state), LOOSE * gate)
    for _ in range(ROUNDS):
        fit = squares.refine(state, own)
        if fit is None:
            return None
        before, own = own, _nearest_of_each(squares, fit, gate)
        if not own.any():
            return None
        if (own == before).all():
            return fit, own
        state = fit.state
    return None


def _nearest_of_each(squares: PoseLeastSquares, fit: PoseEstimate, gate: float) -> NDArray[np.bool_]:
    """Return the observations within the gate; only the nearest one per lamp and image."""
    distances, chosen = fit.distances, np.zeros(len(squares.rays), dtype=np.bool_)
    seen: set[tuple[int, int]] = set()
    for i in np.argsort(distances):
        key = int(squares.rays.ids[i]), int(squares.rays.views[i])
        if distances[i] < gate and key not in seen:
            seen.add(key)
            chosen[i] = True
    return chosen


def _other_places(
    squares: PoseLeastSquares,
    fit: PoseEstimate,
    own: NDArray[np.bool_],
    places: NDArray[np.float64],
    camera: LevelCamera,
    gate: float,
) -> NDArray[np.int64]:
    """Return the index of the known lamp at whose position each outlier is, shape (n,), -1 for none."""
    found = np.full(len(own), -1)
    own_ids = set(squares.rays.ids[own].tolist())
    for i in np.flatnonzero(~own):
        if int(squares.rays.ids[i]) in own_ids:
            continue
        motions = np.tile(squares.rays.motions[i], (len(places), 1))
        points = camera_points(fit.state, places, motions, camera)
        offsets = points[:, :2] / np.maximum(points[:, 2:], 1e-6) - squares.rays.rays[i]
        precision = np.linalg.inv(squares.covariances[i])
        distances = np.sqrt(np.einsum('ni,ij,nj->n', offsets, precision, offsets))
        distances[points[:, 2] <= 0.0] = np.inf
        if distances.min() < LOOSE * gate:
            found[i] = distances.argmin()
    return found
