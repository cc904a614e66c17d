"""Results of localization at taught places."""

from dataclasses import dataclass

import numpy as np

from shirube_core.geometry import SE2, matrix_from_rpy
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.procedure.target_search import (
    NoDetectionReason,
    NoTargetDetection,
    TargetDetection,
    TargetResult,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace

FEATURE_LOG_RATIO = 0.5
"""Log-likelihood ratio of a feature that is seen where it is predicted; neighbours are not independent."""
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
        """Log-likelihood ratio against chance, summed over all targets and features."""
        found = [each.log_likelihood_ratio for each in self.detections if isinstance(each, TargetDetection)]
        return sum(found) + FEATURE_LOG_RATIO * self.displacement.feature_count


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
