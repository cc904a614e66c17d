"""Localizes at one place by the features of the whole taught view, and fits the pose to features and shapes together.

Shapes and features check each other. A pose of the shapes is confirmed by the features that it predicts; only without
confirmation are features detected and matched in the whole image. A pose of the features is unique if no other one
explains the same features elsewhere, as in rows of equal objects.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from shirube_core.geometry import SE2, matrix_from_rpy, wrap_angle
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.features.feature_search import FeatureSearch, MeasuredFeatures, SeenImages
from stereo_landmark.core.features.taught_features import TaughtFeatures
from stereo_landmark.core.place.joint_fit import GATE, JointPoints, fit_jointly
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.procedure.target_search import (
    NoDetectionReason,
    NoTargetDetection,
    TargetDetection,
    TargetResult,
)
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, SpatialPoints, StereoPoints, StereoRig, concatenate

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


CONFIRMING_MIN, FEATURES_MIN = 30, 20
"""Features that confirm a pose of the shapes or a predicted one, and those of a pose that features found."""
FRACTION_MIN = 0.5
"""Minimum fraction of the expected ones; walls of the same texture share some."""
RIVAL_RATIO = 0.6
"""Another pose with at least this fraction of the features makes a pose ambiguous."""
SPARSE_BELOW = 30
"""Places with fewer features cannot veto a pose of the shapes."""
REFINING_STEPS = 3
"""Steps of the fit that predicts the shapes."""
TILT_ERROR_MAX = 0.1
"""Maximum difference of roll and pitch from the known ones [rad]."""
REACH_FACTOR = 1.5
"""A pose may be this much farther than the region in which it is searched."""
SAME_POSITION, SAME_YAW = 0.1, 0.05
"""Poses that are closer are the same [m, rad]."""


class ViewFault(Enum):
    """Why features give no pose."""

    NOT_FOUND = 'the taught view is not recognized'
    AMBIGUOUS = 'ambiguous: several poses match'
    OUTSIDE = 'the pose is outside of the search region'


class ShapePoints(NamedTuple):
    """Points of shapes in the current pair, and the same points as taught, in any order."""

    seen: StereoPoints
    taught: SpatialPoints


class ViewLocalizer:
    """Localizes at one place."""

    def __init__(self, taught: TaughtFeatures, rig: StereoRig, settings: LandmarkSettings) -> None:
        self._taught, self._rig, self._settings = taught, rig, settings
        self._search = FeatureSearch(taught, rig)

    @property
    def is_sparse(self) -> bool:
        """Whether the taught view has too few features."""
        return self._search.count < SPARSE_BELOW

    def confirm(self, state: Floats, images: SeenImages) -> MeasuredFeatures | None:
        """Return the features at a state, shape (6,), None if they do not confirm it."""
        measured = self._search.measure(state, images)
        is_confirmed = len(measured) >= CONFIRMING_MIN and measured.fraction >= FRACTION_MIN
        return measured if is_confirmed else None

    def find(self, images: SeenImages, tilt: tuple[float, float]) -> tuple[Floats, MeasuredFeatures] | ViewFault:
        """Find the pose by features alone.

        Args:
            images: current pair.
            tilt: known roll and pitch of the base [rad].

        Returns:
            state, shape (6,), and the features that it explains.
        """
        state = self._search.find(images.features)
        if state is None or np.abs(state[4:] - tilt).max() > TILT_ERROR_MAX:
            return ViewFault.NOT_FOUND
        measured = self._search.measure(state, images)
        if len(measured) < FEATURES_MIN or measured.fraction < FRACTION_MIN:
            return ViewFault.NOT_FOUND
        rival = self._search.find_rival(images.features, state)
        if rival is None or _is_same(rival, state):
            return state, measured
        is_ambiguous = len(self._search.measure(rival, images)) >= RIVAL_RATIO * len(measured)
        return ViewFault.AMBIGUOUS if is_ambiguous else (state, measured)

    def refine(self, state: Floats, measured: MeasuredFeatures, tilt: tuple[float, float]) -> Floats | None:
        """Return a state, shape (6,), to which measured features are fitted roughly; None if they do not determine it.

        It predicts the shapes.
        """
        points = self._join(measured, ShapePoints(concatenate([]), self._taught.points))
        fit = fit_jointly(points, self._rig, state, tilt, self._settings.place, REFINING_STEPS)
        return None if fit is None else fit.state

    def fit(
        self, state: Floats, measured: MeasuredFeatures, shapes: ShapePoints, tilt: tuple[float, float]
    ) -> PlaceFix | ViewFault:
        """Fit the pose to features and points of shapes.

        Args:
            state: initial state, shape (6,).
            measured: features at this state.
            shapes: points of shapes.
            tilt: known roll and pitch of the base [rad].
        """
        points, count = self._join(measured, shapes), len(shapes.seen)
        fit = fit_jointly(points, self._rig, state, tilt, self._settings.place)
        if fit is None:
            return ViewFault.NOT_FOUND
        search, inliers = self._settings.search, fit.mahalanobis_distances < GATE
        reach, turn = REACH_FACTOR * search.distance_max, REACH_FACTOR * search.yaw_max
        if np.hypot(*fit.state[:2]) > reach or abs(fit.state[3]) > turn:
            return ViewFault.OUTSIDE
        x, y, z, yaw, roll, pitch = fit.state.tolist()
        names = tuple(name for name, kept in zip(shapes.seen.names, inliers[:count], strict=True) if kept)
        return PlaceFix(
            *(SE2(x, y, yaw), z, (roll, pitch), fit.covariance[:4, :4], names, fit.residuals[inliers]),
            int(inliers[count:].sum()),
        )

    def _join(self, measured: MeasuredFeatures, shapes: ShapePoints) -> JointPoints:
        seen, taught = shapes.seen, shapes.taught.select(shapes.seen.names)
        features = self._taught.points
        here = np.concatenate([seen.pixels.reshape(-1, MEASUREMENT_SIZE), measured.pixels])
        return JointPoints(
            here,
            np.concatenate([_count_once(seen), measured.covariances]),
            np.concatenate([taught.positions.reshape(-1, 3), features.positions[measured.indices]]),
            np.concatenate([taught.covariances.reshape(-1, 3, 3), features.covariances[measured.indices]]),
            np.arange(len(here)) >= len(seen),
        )


def state_of(fix: PlaceFix) -> Floats:
    """Return x, y, z [m], yaw, roll and pitch [rad] of a displacement, shape (6,)."""
    pose = fix.T_place_base
    return np.array([pose.x, pose.y, fix.height, pose.yaw, *fix.tilt])


def _is_same(one: Floats, other: Floats) -> bool:
    apart = float(np.linalg.norm(one[:3] - other[:3]))
    return apart < SAME_POSITION and abs(wrap_angle(float(one[3] - other[3]))) < SAME_YAW


DUPLICATE_DISTANCE = 0.7
"""Points of several shapes that are closer are the same point of the image [px]."""


def _count_once(points: StereoPoints) -> Floats:
    """Return the covariances, shape (n, 4, 4), those of points in several shapes times the number of these."""
    gaps = np.linalg.norm(points.pixels[:, None] - points.pixels[None], axis=2)
    return points.covariances * (gaps < DUPLICATE_DISTANCE).sum(axis=1)[:, None, None]
