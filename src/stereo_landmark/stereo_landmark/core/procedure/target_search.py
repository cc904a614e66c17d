"""Searches a taught target in a stereo pair (paper 3.4, fig. 6)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.primitives.primitive import bounding_box, point_names
from stereo_landmark.core.procedure.coarse_pose import image_distances, predict_pixels
from stereo_landmark.core.procedure.guided_matching import (
    GuidedMatcher,
    StereoCandidates,
    find_stereo_candidates,
    fit_points,
    named_pairs,
)
from stereo_landmark.core.procedure.pose_hypotheses import PoseHypothesis, PoseScorer, generate_hypotheses
from stereo_landmark.core.procedure.stereo_view import NamedPair, StereoView, refine_pair, stereo_points
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget, centre_correction
from stereo_landmark.core.settings import SearchSettings
from stereo_landmark.core.stereo import CameraView, SpatialPoints, StereoPoints


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


DISTINCT_POSE_DISTANCE = 15.0
"""Minimum image distance of a primitive between distinct poses [px]."""
GUIDED_MATCHING_WINDOWS = 10.0, 4.0
"""Window of each round of guided matching, each followed by a fit [px]."""
REGION_GROWTH, REGION_MARGIN = 1.1, 12.0
"""Region of a primitive at a known pose: its size, which perspective changes, and window and filter [px]."""
DEPTH_MIN = 0.3
DEPTH_TOLERANCE = 0.3
"""Maximum relative error of a detected depth."""


class _Fit(NamedTuple):
    """A fitted pose hypothesis: state, shape (4,), and a function that returns its matched primitives."""

    state: Floats
    pairs: Callable[[], list[NamedPair]]


class TargetSearch:
    """Searches the targets of one place.

    Args:
        place: taught place.
        settings: search settings; None for the defaults.
    """

    def __init__(self, place: TaughtPlace, settings: SearchSettings | None = None) -> None:
        self._place = place
        self._settings = settings or SearchSettings()
        targets = [primitive for target in place.targets for primitive in target.primitives]
        self._expected = [*targets, *place.context_landmarks]

    def search(self, target: TaughtTarget, view: StereoView) -> TargetDetection | NoTargetDetection:
        """Search a target (paper 3.4, figs 6 to 8)."""
        tolerances, positions = self._place.processing.tolerances, target.positions
        # 1. Candidates of each primitive: similar shapes in both images at a possible depth.
        depths = self._depth_ranges(positions, view)
        candidates = find_stereo_candidates(target.primitives, view, depths, tolerances)
        # 2. Procedure tree: each primitive begins a path; a candidate of it gives the windows of the others.
        hypotheses = generate_hypotheses(positions, candidates, view, self._settings)
        # 3. The pose of each hypothesis by its primitives as detected.
        points = self._taught_points(target)
        fits = [
            _Fit(state, partial(_matched_pairs, target, hypothesis.matches, candidates, view))
            for hypothesis in hypotheses
            if (state := _fit_pose(hypothesis, points, candidates, view)) is not None
        ]
        if not fits:
            detail = f'searched for {len(target.primitives)} primitives'
            return NoTargetDetection(target.name, NoDetectionReason.NO_CANDIDATE, detail)
        # 4. Primitives are matched again at the pixels that the pose predicts.
        fits = self._match_again(GuidedMatcher(target, points, view, tolerances), fits)
        return self._select(target, fits, view, self._expected, self._settings.log_likelihood_ratio_min)

    def search_at(self, target: TaughtTarget, view: StereoView, state: Floats) -> TargetDetection | NoTargetDetection:
        """Search a target at a known pose.

        Args:
            target: target of the place.
            view: stereo view with the place's kinds of primitives, at least in the regions of the target.
            state: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        """
        matcher = GuidedMatcher(target, self._taught_points(target), view, self._place.processing.tolerances)
        chosen = matcher.match(state[None], GUIDED_MATCHING_WINDOWS[0])[0]
        if (chosen[:, 0] < 0).all():
            return NoTargetDetection(target.name, NoDetectionReason.NO_CANDIDATE, 'not where the view predicts it')
        # The pose is significant already.
        return self._select(target, [_Fit(state, partial(matcher.pairs, chosen))], view, target.primitives, 0.0)

    def _select(
        self,
        target: TaughtTarget,
        fits: list[_Fit],
        view: StereoView,
        expected: Sequence[TaughtPrimitive],
        ratio_min: float,
    ) -> TargetDetection | NoTargetDetection:
        """Return the most likely of the fitted poses, if it is significant and unique, with refined primitives."""
        tolerances = self._place.processing.tolerances
        # 5. Log-likelihood ratio: all expected primitives that should be visible, against chance.
        states = np.array([fit.state for fit in fits])
        ratios = PoseScorer(expected, view, tolerances, self._settings).score(states)
        order = np.argsort(-ratios, kind='stable')
        # 6. The best pose must be significant, and no other pose about as likely.
        fault = self._check_best(target, states[order], ratios[order], view, ratio_min)
        if fault is not None:
            return fault
        # 7. Only the primitives of the best pose are refined in the grey images.
        best, ratio = fits[int(order[0])], float(ratios[order[0]])
        images = view.left.image, view.right.image
        refined = ((name, refine_pair(left, right, images)) for name, left, right in best.pairs())
        measured = [(name, *pair) for name, pair in refined if pair is not None]
        # 8. Corresponding points (3.3d); apparent centres of circles are those of the taught view.
        seen = correct_circle_centres(stereo_points(measured), target, best.state, view)
        return TargetDetection(target.name, best.state, seen, tuple(name for name, *_ in measured), ratio)

    def _depth_ranges(self, positions: Floats, view: StereoView) -> Floats:
        """Return the smallest and largest depth of each primitive, shape (k, 2) [m]."""
        distances = np.linalg.norm(positions - view.camera.position, axis=1)
        margins = self._settings.distance_max + DEPTH_TOLERANCE * distances
        nearest = np.maximum(DEPTH_MIN, distances * np.cos(self._settings.yaw_max) - margins)
        return np.column_stack([nearest, distances + margins])

    def _taught_points(self, target: TaughtTarget) -> list[SpatialPoints]:
        """Return the taught points of each primitive in the place's frame."""
        return [
            self._place.coordinates.select(point_names([(f'{target.name}/{taught.name}', taught.shape)]))
            for taught in target.primitives
        ]

    def _match_again(self, matcher: GuidedMatcher, fits: list[_Fit]) -> list[_Fit]:
        """Match and fit again, where guided matching finds enough primitives."""
        # Hypotheses near the same pose converge to the same matches, which are fitted only once.
        states: dict[bytes, Floats | None] = {}
        for window in GUIDED_MATCHING_WINDOWS:
            chosen = matcher.match(np.array([fit.state for fit in fits]), window)
            least = max(2.0, self._settings.found_fraction_min * chosen.shape[1])
            for h in np.flatnonzero((chosen[:, :, 0] >= 0).sum(axis=1) >= least).tolist():
                matched = chosen[h].tobytes()
                if matched not in states:
                    states[matched] = matcher.fit(fits[h].state, chosen[h])
                state = states[matched]
                if state is not None:
                    fits[h] = _Fit(state, partial(matcher.pairs, chosen[h]))
        return fits

    def _check_best(
        self, target: TaughtTarget, states: Floats, ratios: Floats, view: StereoView, needed: float
    ) -> NoTargetDetection | None:
        """Return why the first of the poses, the most likely first, is not accepted; None if it is."""
        if ratios[0] < needed:
            detail = f'log-likelihood ratio {ratios[0]:.1f}, {needed:g} is needed'
            return NoTargetDetection(target.name, NoDetectionReason.NOT_SIGNIFICANT, detail)
        rivals = ratios[image_distances(states, target.positions, view) > DISTINCT_POSE_DISTANCE]
        if len(rivals) and ratios[0] - rivals[0] < self._settings.margin:
            detail = f'log-likelihood ratios {ratios[0]:.1f} and {rivals[0]:.1f}'
            return NoTargetDetection(target.name, NoDetectionReason.AMBIGUOUS, detail)
        return None


def _fit_pose(
    hypothesis: PoseHypothesis,
    taught: Sequence[SpatialPoints],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
) -> Floats | None:
    """Fit the pose to the matched primitives as detected; None if it is not observable."""
    seen = {k: candidates[k].points[i] for k, i in enumerate(hypothesis.matches.tolist()) if i >= 0}
    return fit_points(hypothesis.state, taught, seen, view)


def target_regions(target: TaughtTarget, view: CameraView, state: Floats) -> tuple[Masks, Masks]:
    """Return the masks of the pixels of the left and the right image that a target covers at a pose, shape (h, w).

    Args:
        target: target of the place.
        view: cameras and tilt.
        state: x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
    """
    camera = view.rig.left
    centres = predict_pixels(state[None], target.positions, view)[0]
    taught = predict_pixels(np.zeros((1, 4)), target.positions, view)[0]
    growths = view.rig.disparities(centres) / view.rig.disparities(taught)
    masks = np.zeros((2, camera.height, camera.width), dtype=np.bool_)
    for primitive, centre, growth in zip(target.primitives, centres, growths, strict=True):
        reach = REGION_GROWTH * growth * (bounding_box(primitive.shape) - primitive.shape.centre)
        for mask, middle in zip(masks, (centre[:2], centre[2:]), strict=True):
            low, high = middle + reach[0] - REGION_MARGIN, middle + reach[1] + REGION_MARGIN
            if np.isfinite([*low, *high]).all():
                (u, v), (right, bottom) = np.maximum(np.rint([low, high]).astype(int), 0).tolist()
                mask[v:bottom, u:right] = True
    return masks[0], masks[1]


def correct_circle_centres(points: StereoPoints, target: TaughtTarget, state: Floats, view: CameraView) -> StereoPoints:
    """Return points with the centres of circles corrected for the change of viewpoint."""
    pixels = points.pixels.copy()
    for taught in target.primitives:
        name = f'{target.name}/{taught.name}/centre'
        if taught.normal is not None and name in points.names:
            pixels[points.names.index(name)] -= centre_correction(taught, state, view)
    return replace(points, pixels=pixels)


def _matched_pairs(
    target: TaughtTarget, matched: Ints, candidates: Sequence[StereoCandidates], view: StereoView
) -> list[NamedPair]:
    """Return the primitives of both images that a hypothesis matched."""
    found = {k: (candidates[k].left[i], candidates[k].right[i]) for k, i in enumerate(matched.tolist()) if i >= 0}
    return named_pairs(target, found, view)
