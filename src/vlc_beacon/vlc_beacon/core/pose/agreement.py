"""The poses that some of the lamps agree on, where not all do."""

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
"""A pose of two lamps tells where others are seen less exactly, by about this factor."""
SAME_WITHIN = 0.005
"""Poses of which no part differs by more are one [m, rad]."""


@dataclass(frozen=True)
class Agreement:
    """A pose and the lamps that speak for it.

    Attributes:
        fit: to the lamps that are where they should be.
        own: shape (n,), sightings of lamps at their own places, each lamp once.
        place: shape (n,), index of the other lamp at whose place a sighting is, -1 where there is none.
    """

    fit: PoseEstimate
    own: NDArray[np.bool_]
    place: NDArray[np.int64]

    @property
    def swapped(self) -> NDArray[np.bool_]:
        """Shape (n,), sightings of lamps at the places of others."""
        return self.place >= 0

    @property
    def score(self) -> int:
        """How many sightings are where a lamp should be."""
        return int(self.own.sum() + self.swapped.sum())


def best_agreements(
    squares: PoseLeastSquares,
    starts: Iterable[NDArray[np.float64]],
    places: NDArray[np.float64],
    camera: LevelCamera,
    gate: float,
) -> list[Agreement]:
    """Return the different poses that lamps agree on, those of most lamps first.

    Args:
        squares: the sightings.
        starts: states to try, each of shape (6,).
        places: shape (m, 3), of all known lamps in the map frame [m].
        camera: where it is on the robot.
        gate: a lamp that is this many standard deviations off does not agree.
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
    """Return the agreement that can be trusted, or None.

    More lamps than the pose needs must speak for it and no other pose have as many; else the only one that is where
    the robot is expected is taken.

    Args:
        agreements: as `best_agreements` returns them.
        unknowns: of the pose.
        expected: where the robot should be, None where nobody knows.
        within: standard deviations that a pose may be off the expected one.
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
    """Return a fit to the sightings that agree with it, and which these are."""
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
    """Return the sightings within the gate; of an image's sightings of the same lamp only the nearest."""
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
    """Return at which known place each other sighting is, shape (n,), -1 for none."""
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
