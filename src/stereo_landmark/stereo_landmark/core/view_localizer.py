"""Localizes at one place by the features of the whole taught view, and fits the pose to features and shapes together.

Shapes and features check each other. A pose of the shapes is confirmed by the features that it predicts; only without
confirmation are features detected and matched in the whole image. A pose of the features is unique if no other one
explains the same features elsewhere, as in rows of equal objects.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np

from shirube_core.geometry import SE2, wrap_angle
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.features.feature_search import FeatureSearch, MeasuredFeatures, SeenImages
from stereo_landmark.core.features.taught_features import TaughtFeatures
from stereo_landmark.core.place.joint_fit import GATE, JointPoints, fit_jointly
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, SpatialPoints, StereoPoints, StereoRig, concatenate

CONFIRMING_MIN, CONFIRMING_FRACTION = 30, 0.5
"""Features that confirm a pose of the shapes: minimum number and fraction of the expected ones."""
FEATURES_MIN, FRACTION_MIN = 20, 0.2
"""The same for a pose that features found."""
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
    """Localizes at one place.

    Args:
        taught: features of the taught pair.
        rig: current stereo cameras.
        settings: localization settings.
    """

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
        is_confirmed = len(measured) >= CONFIRMING_MIN and measured.fraction >= CONFIRMING_FRACTION
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
        search, inliers = self._settings.search, fit.distances < GATE
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
