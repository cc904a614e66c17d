"""Consensus of a subset of the lamps, used when no pose explains all of them, and what is wrong with the others."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE3
from vlc_beacon.core.pose.lamp_rays import LampRays
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconAnomaly, ExpectedPose
from vlc_beacon.core.pose.pose_least_squares import PoseEstimate, PoseLeastSquares, camera_points

ITERATIONS_MAX = 3
LOOSE_GATE_FACTOR = 3.0
"""Factor on the gate of a pose from two lamps, which predicts other lamps less accurately."""
SAME_POSE_TOLERANCE = 0.005
"""Poses whose components differ by less are equal [m, rad]."""


@dataclass(frozen=True)
class ConsensusSet:
    """A pose and its consensus set.

    Attributes:
        fit: pose fitted to the inliers.
        inliers: mask of the inliers, observations of lamps at their own positions, each lamp once, shape (n,).
        swapped_place: index of the other lamp at whose position an observation is, -1 for none, shape (n,).
    """

    fit: PoseEstimate
    inliers: NDArray[np.bool_]
    swapped_place: NDArray[np.int64]

    @property
    def swapped(self) -> NDArray[np.bool_]:
        """Mask of observations of lamps at the positions of others, shape (n,)."""
        return self.swapped_place >= 0

    @property
    def score(self) -> int:
        """Number of observations at the position of a known lamp."""
        return int(self.inliers.sum() + self.swapped.sum())


def find_consensus_sets(
    problem: PoseLeastSquares,
    initial_states: Iterable[NDArray[np.float64]],
    lamp_positions: NDArray[np.float64],
    camera: SE3,
    gate: float,
) -> list[ConsensusSet]:
    """Return the distinct consensus sets, those with most lamps first.

    Args:
        problem: least-squares problem of the observations.
        initial_states: initial states, each of shape (6,).
        lamp_positions: positions of all known lamps in the map frame, shape (m, 3) [m].
        camera: gravity-aligned camera pose on the robot.
        gate: maximum residual of an inlier [standard deviations].
    """
    consensus_sets: list[ConsensusSet] = []
    for start in initial_states:
        fitted = _fit_inliers(problem, start, gate)
        if fitted is None:
            continue
        fit, inliers = fitted
        if any(fit.is_within(SAME_POSE_TOLERANCE, known.fit) for known in consensus_sets):
            continue
        swapped_place = _match_swapped(problem, fit, inliers, lamp_positions, camera, gate)
        consensus_sets.append(ConsensusSet(fit, inliers, swapped_place))
    consensus_sets.sort(key=lambda consensus: (-consensus.score, -int(consensus.inliers.sum())))
    return consensus_sets


def select_consensus_set(
    consensus_sets: list[ConsensusSet], unknowns: int, expected: ExpectedPose | None, within: float
) -> ConsensusSet | None:
    """Select a reliable consensus set, or return None.

    It must contain more lamps than the minimum for a pose, and no other set may have as many; otherwise the only set
    consistent with the expected pose is used.

    Args:
        consensus_sets: consensus sets, sorted by size.
        unknowns: number of unknowns of the pose.
        expected: expected pose, None if unknown.
        within: maximum distance from the expected pose [standard deviations].
    """
    if not consensus_sets:
        return None
    best = [consensus for consensus in consensus_sets if consensus.score == consensus_sets[0].score]
    if len(best) == 1 and 2 * best[0].score > unknowns:
        return best[0]
    if expected is None:
        return None
    nearby = [consensus for consensus in best if consensus.fit.mahalanobis_distance_to(expected) < within]
    return nearby[0] if len(nearby) == 1 else None


def _fit_inliers(
    problem: PoseLeastSquares, state: NDArray[np.float64], gate: float
) -> tuple[PoseEstimate, NDArray[np.bool_]] | None:
    """Fit iteratively to the inliers; return the fit and the mask of the inliers."""
    inliers = _gate_observations(problem, problem.evaluate(state), LOOSE_GATE_FACTOR * gate)
    for _ in range(ITERATIONS_MAX):
        fit = problem.refine(state, inliers)
        if fit is None:
            return None
        previous, inliers = inliers, _gate_observations(problem, fit, gate)
        if not inliers.any():
            return None
        if (inliers == previous).all():
            return fit, inliers
        state = fit.state
    return None


def _gate_observations(problem: PoseLeastSquares, fit: PoseEstimate, gate: float) -> NDArray[np.bool_]:
    """Return the observations within the gate; only the nearest one per lamp and image."""
    distances, chosen = fit.distances, np.zeros(len(problem.rays), dtype=np.bool_)
    seen: set[tuple[int, int]] = set()
    for i in np.argsort(distances):
        key = int(problem.rays.ids[i]), int(problem.rays.views[i])
        if distances[i] < gate and key not in seen:
            seen.add(key)
            chosen[i] = True
    return chosen


def _match_swapped(
    problem: PoseLeastSquares,
    fit: PoseEstimate,
    inliers: NDArray[np.bool_],
    lamp_positions: NDArray[np.float64],
    camera: SE3,
    gate: float,
) -> NDArray[np.int64]:
    """Return the index of the known lamp at whose position each outlier is, shape (n,), -1 for none."""
    found = np.full(len(inliers), -1)
    inlier_ids = set(problem.rays.ids[inliers].tolist())
    for i in np.flatnonzero(~inliers):
        if int(problem.rays.ids[i]) in inlier_ids:
            continue
        motions = np.tile(problem.rays.motions[i], (len(lamp_positions), 1))
        points = camera_points(fit.state, lamp_positions, motions, camera)
        offsets = points[:, :2] / np.maximum(points[:, 2:], 1e-6) - problem.rays.rays[i]
        precision = np.linalg.inv(problem.covariances[i])
        distances = np.sqrt(np.einsum('ni,ij,nj->n', offsets, precision, offsets))
        distances[points[:, 2] <= 0.0] = np.inf
        if distances.min() < LOOSE_GATE_FACTOR * gate:
            found[i] = distances.argmin()
    return found


def classify_anomalies(rays: LampRays, consensus: ConsensusSet, beacon_ids: Sequence[int]) -> tuple[BeaconAnomaly, ...]:
    """Return the anomaly of each outlier; ``beacon_ids`` are indexed by ``consensus.swapped_place``."""
    anomalies, is_duplicate = [], rays.is_duplicate
    for i in np.flatnonzero(~consensus.inliers).tolist():
        kind, other = AnomalyKind.MOVED, None
        if is_duplicate[i]:
            kind = AnomalyKind.DUPLICATED
        elif consensus.swapped[i]:
            kind, other = AnomalyKind.SWAPPED, beacon_ids[consensus.swapped_place[i]]
        anomalies.append(BeaconAnomaly(int(rays.ids[i]), i, kind, other))
    return tuple(anomalies)


def unclassified_anomalies(rays: LampRays) -> tuple[BeaconAnomaly, ...]:
    """Return an unclassified anomaly for each observation: at least one is wrong, but it is unknown which."""
    return tuple(
        BeaconAnomaly(int(id_), i, AnomalyKind.DUPLICATED if is_duplicate else AnomalyKind.UNCLEAR)
        for i, (id_, is_duplicate) in enumerate(zip(rays.ids, rays.is_duplicate, strict=True))
    )
