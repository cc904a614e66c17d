"""Results of localization: the place, the displacement and the detected targets, or why there is no pose."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from shirube_core.geometry import SE2, matrix_from_rpy
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import StereoPoints


@dataclass(frozen=True)
class TargetDetection:
    """A detected target.

    Attributes:
        target: name of the target.
        state: coarse x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        points: points refined in the grey images, named ``target/primitive/point``.
        found: names of the detected primitives.
        log_likelihood_ratio: log-likelihood ratio against chance.
    """

    target: str
    state: Floats
    points: StereoPoints
    found: tuple[str, ...]
    log_likelihood_ratio: float


class NoDetectionReason(Enum):
    """Why a target is not detected."""

    NO_CANDIDATE = 'no similar shapes in view'
    NOT_SIGNIFICANT = 'the match could be due to chance'
    AMBIGUOUS = 'ambiguous: several poses match'


@dataclass(frozen=True)
class NoTargetDetection:
    """A target that was not detected, and why.

    Attributes:
        target: name of the target.
        reason: kind of failure.
        detail: numbers for the diagnostics.
    """

    target: str
    reason: NoDetectionReason
    detail: str


TargetResult = TargetDetection | NoTargetDetection
_STAGES = (NoDetectionReason.NO_CANDIDATE, NoDetectionReason.NOT_SIGNIFICANT, NoDetectionReason.AMBIGUOUS)
"""Stages of the target search in the order in which they can fail."""


@dataclass(frozen=True)
class LandmarkFix:
    """Pose of the robot at a taught place.

    Attributes:
        place: recognized place.
        displacement: displacement from the taught pose.
        detections: detection results of the targets.
        matched_patches: names of the primitives measured by patch alignment; the others are measured by their outlines.
    """

    place: TaughtPlace
    displacement: PlaceFix
    detections: tuple[TargetResult, ...]
    matched_patches: tuple[str, ...] = ()

    @property
    def T_map_base(self) -> SE2 | None:  # noqa: N802
        """Pose of the robot in the map, None if the place has no map pose."""
        T_map_place = self.place.T_map_place
        return None if T_map_place is None else T_map_place @ self.displacement.T_place_base

    @property
    def map_covariance(self) -> Floats:
        """Covariance of x, y [m] and yaw [rad] in the map, shape (3, 3); in the place's frame if it has no map pose."""
        T_map_place = self.place.T_map_place
        turn = matrix_from_rpy((0.0, 0.0, 0.0 if T_map_place is None else T_map_place.yaw))
        planar = self.displacement.covariance[np.ix_([0, 1, 3], [0, 1, 3])]
        return np.asarray(turn @ planar @ turn.T)

    @property
    def log_likelihood_ratio(self) -> float:
        """Log-likelihood ratio against chance, summed over all targets."""
        return sum(each.log_likelihood_ratio for each in self.detections if isinstance(each, TargetDetection))


@dataclass(frozen=True)
class NoLandmarkFix:
    """No pose, and why.

    Attributes:
        reason: message, the same for the same kind of failure.
        detail: numbers and names for the diagnostics.
        detections: detection results at the place that came nearest to a fix.
    """

    reason: str
    detail: str
    detections: tuple[TargetResult, ...] = ()

    @property
    def progress(self) -> tuple[int, float]:
        """Progress for comparison: stage of the best target, and log-likelihood ratio of the detected ones."""
        found = [each for each in self.detections if isinstance(each, TargetDetection)]
        stages = [
            _STAGES.index(each.reason) if isinstance(each, NoTargetDetection) else len(_STAGES)
            for each in self.detections
        ]
        return max(stages, default=0), sum(each.log_likelihood_ratio for each in found)


def describe_failure(
    place: TaughtPlace, detections: tuple[TargetResult, ...], fault: NoPlaceFix
) -> NoLandmarkFix:
    """Return why a place gave no pose: the points of its targets were rejected, or no target was detected."""
    missing = [each for each in detections if isinstance(each, NoTargetDetection)]
    if len(missing) < len(detections):
        return NoLandmarkFix(fault.reason.value, f'place {place.name}: {fault.detail}', detections)
    reason = missing[0].reason.value
    detail = '; '.join(f'{each.target}: {each.reason.value} ({each.detail})' for each in missing)
    return NoLandmarkFix(reason, f'place {place.name}: {detail}', detections)
