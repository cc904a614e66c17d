"""Searches a taught target in a stereo pair (paper 3.4, fig. 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import NoDetectionReason, NoTargetDetection, TargetDetection
from stereo_landmark.core.primitives.primitive import invariant_points
from stereo_landmark.core.procedure.candidate_search import StereoCandidates, find_stereo_candidates
from stereo_landmark.core.procedure.coarse_pose_fit import fit_coarse_pose
from stereo_landmark.core.procedure.guided_matching import GuidedMatcher
from stereo_landmark.core.procedure.pose_hypotheses import PoseHypothesis, generate_hypotheses
from stereo_landmark.core.procedure.pose_scorer import PoseScorer
from stereo_landmark.core.procedure.prediction import centre_correction, image_distances
from stereo_landmark.core.procedure.stereo_measurement import (
    NamedPair,
    align_pair,
    refine_pair,
    stereo_points,
)
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget
from stereo_landmark.core.settings import SearchSettings
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints

DISTINCT_POSE_DISTANCE = 15.0
"""Minimum image distance of a primitive between distinct poses [px]."""
GUIDED_MATCHING_WINDOWS = 10.0, 4.0
"""Window of each round of guided matching, each followed by a fit [px]."""
DEPTH_MIN = 0.3
DEPTH_TOLERANCE = 0.3
"""Maximum relative error of a detected depth."""


@dataclass(frozen=True)
class _FittedHypothesis:
    """A fitted pose hypothesis: state, shape (4,), and a function that returns its matched primitives."""

    state: NDArray[np.float64]
    pairs: Callable[[], list[NamedPair]]


@dataclass(frozen=True)
class _ScoredHypothesis(_FittedHypothesis):
    """A fitted pose hypothesis with its log-likelihood ratio."""

    log_likelihood_ratio: float


class TargetSearch:
    """Searches the targets of one place.

    Args:
        place: taught place.
        settings: search settings; None for the defaults.
    """

    def __init__(self, place: TaughtPlace, settings: SearchSettings | None = None) -> None:
        self._place = place
        self._settings = settings or SearchSettings()

    def search(self, target: TaughtTarget, view: StereoView) -> TargetDetection | NoTargetDetection:
        """Search a target.

        Args:
            target: target of the place.
            view: stereo view with the place's kinds of primitives.
        """
        positions = np.array([taught.position for taught in target.primitives])
        best = self._accept_best(target, self._score_hypotheses(target, positions, view), positions, view)
        if isinstance(best, NoTargetDetection):
            return best
        images = view.left.image, view.right.image
        measured: list[NamedPair] = []
        for name, left, right in best.pairs():
            pair = refine_pair(left, right, images)
            if pair is not None:
                measured.append((name, *pair))
        found = tuple(name for name, _, _ in measured)
        points = _correct_circle_centres(stereo_points(measured), target, best.state, view)
        return TargetDetection(target.name, best.state, points, found, best.log_likelihood_ratio)

    def _score_hypotheses(
        self, target: TaughtTarget, positions: NDArray[np.float64], view: StereoView
    ) -> list[_ScoredHypothesis]:
        """Generate, fit and score pose hypotheses, the most likely first."""
        candidates = self._candidates(target, view)
        points = self._invariant_points(target)
        fitted = [
            _FittedHypothesis(state, partial(_matched_pairs, target, hypothesis.matches, candidates, view))
            for hypothesis in generate_hypotheses(positions, candidates, view, self._settings)
            if (state := _fit_pose(hypothesis, points, candidates, view)) is not None
        ]
        if not fitted:
            return []
        fitted = self._refine_matches(
            GuidedMatcher(target, points, view, self._place.processing.tolerances), fitted
        )
        ratios = self._pose_scorer(view).score(np.array([each.state for each in fitted])).tolist()
        hypotheses = [
            _ScoredHypothesis(each.state, each.pairs, ratio)
            for each, ratio in zip(fitted, ratios, strict=True)
        ]
        return sorted(hypotheses, key=lambda hypothesis: -hypothesis.log_likelihood_ratio)

    def _refine_matches(
        self, matcher: GuidedMatcher, fitted: list[_FittedHypothesis]
    ) -> list[_FittedHypothesis]:
        """Refine hypotheses by guided matching, where it finds enough primitives."""
        # Hypotheses near the same pose converge to the same matches, which are fitted only once.
        states: dict[bytes, NDArray[np.float64] | None] = {}
        for window in GUIDED_MATCHING_WINDOWS:
            chosen = matcher.match(np.array([each.state for each in fitted]), window)
            least = max(2.0, self._settings.found_fraction_min * chosen.shape[1])
            for h in np.flatnonzero((chosen[:, :, 0] >= 0).sum(axis=1) >= least).tolist():
                matched = chosen[h].tobytes()
                if matched not in states:
                    states[matched] = matcher.fit(fitted[h].state, chosen[h])
                state = states[matched]
                if state is not None:
                    fitted[h] = _FittedHypothesis(state, partial(matcher.pairs, chosen[h]))
        return fitted

    def _candidates(self, target: TaughtTarget, view: StereoView) -> list[StereoCandidates]:
        """Return the candidates of each primitive of the target within its depth range."""
        tolerances, distance_max = self._place.processing.tolerances, self._settings.distance_max
        positions = np.array([taught.position for taught in target.primitives])
        distances = np.linalg.norm(positions - view.camera.position, axis=1)
        depth_margin = distance_max + DEPTH_TOLERANCE * distances
        nearest = np.maximum(DEPTH_MIN, distances * np.cos(self._settings.yaw_max) - depth_margin)
        depths = np.column_stack([nearest, distances + depth_margin])
        return find_stereo_candidates(target.primitives, view, depths, tolerances)

    def _pose_scorer(self, view: StereoView) -> PoseScorer:
        place = self._place
        expected = [primitive for target in place.targets for primitive in target.primitives]
        return PoseScorer(
            [*expected, *place.context_landmarks], view, place.processing.tolerances, self._settings
        )

    def _invariant_points(self, target: TaughtTarget) -> list[SpatialPoints]:
        """Return the taught points of each primitive in the place's frame."""
        return [
            self._place.coordinates.select(
                tuple(f'{target.name}/{taught.name}/{point}' for point in invariant_points(taught.shape))
            )
            for taught in target.primitives
        ]

    def _accept_best(
        self,
        target: TaughtTarget,
        hypotheses: list[_ScoredHypothesis],
        positions: NDArray[np.float64],
        view: StereoView,
    ) -> _ScoredHypothesis | NoTargetDetection:
        """Return the best hypothesis if it is significant and unambiguous, otherwise the reason why it is not."""
        if not hypotheses:
            detail = f'searched for {len(target.primitives)} primitives'
            return NoTargetDetection(target.name, NoDetectionReason.NO_CANDIDATE, detail)
        best = hypotheses[0]
        if best.log_likelihood_ratio < self._settings.log_likelihood_ratio_min:
            needed = self._settings.log_likelihood_ratio_min
            detail = f'log-likelihood ratio {best.log_likelihood_ratio:.1f}, {needed:g} is needed'
            return NoTargetDetection(target.name, NoDetectionReason.NOT_SIGNIFICANT, detail)
        apart = image_distances(np.array([hypothesis.state for hypothesis in hypotheses]), positions, view)
        others = [
            hypothesis
            for hypothesis, far in zip(hypotheses, apart, strict=True)
            if far > DISTINCT_POSE_DISTANCE
        ]
        if others and best.log_likelihood_ratio - others[0].log_likelihood_ratio < self._settings.margin:
            detail = f'log-likelihood ratios {best.log_likelihood_ratio:.1f} and {others[0].log_likelihood_ratio:.1f}'
            return NoTargetDetection(target.name, NoDetectionReason.AMBIGUOUS, detail)
        return best


def _fit_pose(
    hypothesis: PoseHypothesis,
    taught: Sequence[SpatialPoints],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
) -> NDArray[np.float64] | None:
    """Fit the pose to the matched primitives as detected; None if it is not observable."""
    matched = [(k, i) for k, i in enumerate(hypothesis.matches.tolist()) if i >= 0]
    positions = np.concatenate([taught[k].positions for k, _ in matched])
    covariances = np.concatenate([taught[k].covariances for k, _ in matched])
    observed = np.concatenate([candidates[k].points[i] for k, i in matched])
    return fit_coarse_pose(hypothesis.state, positions, covariances, observed, view)


def _correct_circle_centres(
    points: StereoPoints, target: TaughtTarget, state: NDArray[np.float64], view: StereoView
) -> StereoPoints:
    """Return points with the centres of circles corrected for the change of viewpoint."""
    pixels = points.pixels.copy()
    for taught in target.primitives:
        name = f'{target.name}/{taught.name}/centre'
        if taught.normal is not None and name in points.names:
            pixels[points.names.index(name)] -= centre_correction(taught, state, view)
    return replace(points, pixels=pixels)


def _matched_pairs(
    target: TaughtTarget,
    matched: NDArray[np.int64],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
) -> list[NamedPair]:
    """Return the primitives of both images that a hypothesis matched."""
    pairs: list[NamedPair] = []
    for taught, found, i in zip(target.primitives, candidates, matched.tolist(), strict=True):
        if i >= 0:
            here, there = view.detected_pair(taught.kind)
            left, right = here.primitives[found.left[i]], there.primitives[found.right[i]]
            pairs.append((f'{target.name}/{taught.name}', *align_pair(taught.shape, left, right)))
    return pairs
