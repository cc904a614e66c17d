"""Searches a taught target in a stereo pair (paper 3.4, fig. 6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints, StereoPoints
from stereo_landmark.core.procedure.circles import centre_motion
from stereo_landmark.core.procedure.coarse_fit import coarse_fit
from stereo_landmark.core.procedure.evidence import Evidence
from stereo_landmark.core.procedure.prediction import poses_apart
from stereo_landmark.core.procedure.primitive import refined_pair
from stereo_landmark.core.procedure.rematch import Rematch
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.sighting import NoSightingReason, NoTargetSighting, TargetSighting
from stereo_landmark.core.procedure.stereo_candidates import StereoCandidates, stereo_candidates
from stereo_landmark.core.procedure.stereo_measurement import (
    NamedPair,
    invariant_points,
    pair_as_taught,
    stereo_points,
)
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.suppositions import Supposition, suppose
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget

APART = 15.0
"""Minimum image distance of a primitive between distinct poses [px]."""
REMATCH_WINDOWS = 10.0, 4.0
"""Window of each round of guided matching, each followed by a fit [px]."""
DEPTH_MIN = 0.3
DEPTH_SHARE = 0.3
"""Maximum relative error of a detected depth."""


@dataclass(frozen=True)
class _Supposed:
    """A fitted pose hypothesis: state, shape (4,), and a function that returns its matched primitives."""

    state: NDArray[np.float64]
    pairs: Callable[[], list[NamedPair]]


@dataclass(frozen=True)
class _Reading(_Supposed):
    """A fitted pose hypothesis with its log-likelihood ratio."""

    evidence: float


class TargetSearch:
    """Searches the targets of one place.

    Args:
        place: taught place.
        settings: search settings; None for the defaults.
    """

    def __init__(self, place: TaughtPlace, settings: SearchSettings | None = None) -> None:
        self._place = place
        self._settings = settings or SearchSettings()

    def search(self, target: TaughtTarget, view: StereoView) -> TargetSighting | NoTargetSighting:
        """Search a target.

        Args:
            target: target of the place.
            view: stereo view with the place's kinds of primitives.
        """
        positions = np.array([taught.position for taught in target.primitives])
        best = self._verdict(target, self._readings(target, positions, view), positions, view)
        if isinstance(best, NoTargetSighting):
            return best
        images = view.left.image, view.right.image
        measured: list[NamedPair] = []
        for name, left, right in best.pairs():
            pair = refined_pair(left, right, images)
            if pair is not None:
                measured.append((name, *pair))
        found = tuple(name for name, _, _ in measured)
        points = _without_motion(stereo_points(measured), target, best.state, view)
        return TargetSighting(target.name, best.state, points, found, best.evidence)

    def _readings(
        self, target: TaughtTarget, positions: NDArray[np.float64], view: StereoView
    ) -> list[_Reading]:
        """Generate, fit and score pose hypotheses, the most likely first."""
        candidates = self._candidates(target, view)
        points = self._invariant_points(target)
        fitted = [
            _Supposed(state, partial(_pairs, target, supposed.matched, candidates, view))
            for supposed in suppose(positions, candidates, view, self._settings)
            if (state := _fitted(supposed, points, candidates, view)) is not None
        ]
        if not fitted:
            return []
        fitted = self._matched_again(Rematch(target, points, view, self._place.processing.tolerances), fitted)
        weights = self._evidence(view).weigh(np.array([each.state for each in fitted])).tolist()
        readings = [
            _Reading(each.state, each.pairs, weight) for each, weight in zip(fitted, weights, strict=True)
        ]
        return sorted(readings, key=lambda reading: -reading.evidence)

    def _matched_again(self, rematch: Rematch, fitted: list[_Supposed]) -> list[_Supposed]:
        """Refine hypotheses by guided matching, where it finds enough primitives."""
        # Hypotheses near the same pose converge to the same matches, which are fitted only once.
        states: dict[bytes, NDArray[np.float64] | None] = {}
        for window in REMATCH_WINDOWS:
            chosen = rematch.matched(np.array([each.state for each in fitted]), window)
            least = max(2.0, self._settings.seen_min * chosen.shape[1])
            for h in np.flatnonzero((chosen[:, :, 0] >= 0).sum(axis=1) >= least).tolist():
                matched = chosen[h].tobytes()
                if matched not in states:
                    states[matched] = rematch.fitted(fitted[h].state, chosen[h])
                state = states[matched]
                if state is not None:
                    fitted[h] = _Supposed(state, partial(rematch.pairs, chosen[h]))
        return fitted

    def _candidates(self, target: TaughtTarget, view: StereoView) -> list[StereoCandidates]:
        """Return the candidates of each primitive of the target within its depth range."""
        tolerances, reach = self._place.processing.tolerances, self._settings.reach
        positions = np.array([taught.position for taught in target.primitives])
        distances = np.linalg.norm(positions - view.camera.position, axis=1)
        slack = reach + DEPTH_SHARE * distances
        nearest = np.maximum(DEPTH_MIN, distances * np.cos(self._settings.turn) - slack)
        depths = np.column_stack([nearest, distances + slack])
        return stereo_candidates(target.primitives, view, depths, tolerances)

    def _evidence(self, view: StereoView) -> Evidence:
        place = self._place
        expected = [primitive for target in place.targets for primitive in target.primitives]
        return Evidence([*expected, *place.surroundings], view, place.processing.tolerances, self._settings)

    def _invariant_points(self, target: TaughtTarget) -> list[SpatialPoints]:
        """Return the taught points of each primitive in the place's frame."""
        return [
            self._place.coordinates.selected(
                tuple(f'{target.name}/{taught.name}/{point}' for point in invariant_points(taught.shape))
            )
            for taught in target.primitives
        ]

    def _verdict(
        self,
        target: TaughtTarget,
        readings: list[_Reading],
        positions: NDArray[np.float64],
        view: StereoView,
    ) -> _Reading | NoTargetSighting:
        """Return the best hypothesis if it is significant and unambiguous, otherwise the reason why it is not."""
        if not readings:
            detail = f'searched for {len(target.primitives)} primitives'
            return NoTargetSighting(target.name, NoSightingReason.NO_CANDIDATE, detail)
        best = readings[0]
        if best.evidence < self._settings.evidence_min:
            needed = self._settings.evidence_min
            detail = f'log-likelihood ratio {best.evidence:.1f}, {needed:g} is needed'
            return NoTargetSighting(target.name, NoSightingReason.NO_EVIDENCE, detail)
        apart = poses_apart(np.array([reading.state for reading in readings]), positions, view)
        others = [reading for reading, far in zip(readings, apart, strict=True) if far > APART]
        if others and best.evidence - others[0].evidence < self._settings.margin:
            detail = f'log-likelihood ratios {best.evidence:.1f} and {others[0].evidence:.1f}'
            return NoTargetSighting(target.name, NoSightingReason.AMBIGUOUS, detail)
        return best


def _fitted(
    supposed: Supposition,
    taught: Sequence[SpatialPoints],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
) -> NDArray[np.float64] | None:
    """Fit the pose to the matched primitives as detected; None if it is not observable."""
    matched = [(k, i) for k, i in enumerate(supposed.matched.tolist()) if i >= 0]
    positions = np.concatenate([taught[k].positions for k, _ in matched])
    covariances = np.concatenate([taught[k].covariances for k, _ in matched])
    seen = np.concatenate([candidates[k].points[i] for k, i in matched])
    return coarse_fit(supposed.state, positions, covariances, seen, view)


def _without_motion(
    points: StereoPoints, target: TaughtTarget, state: NDArray[np.float64], view: StereoView
) -> StereoPoints:
    """Return points with the centres of circles corrected for the change of viewpoint."""
    pixels = points.pixels.copy()
    for taught in target.primitives:
        name = f'{target.name}/{taught.name}/centre'
        if taught.normal is not None and name in points.names:
            pixels[points.names.index(name)] -= centre_motion(taught, state, view)
    return replace(points, pixels=pixels)


def _pairs(
    target: TaughtTarget,
    matched: NDArray[np.int64],
    candidates: Sequence[StereoCandidates],
    view: StereoView,
) -> list[NamedPair]:
    """Return the primitives of both images that a hypothesis matched."""
    pairs: list[NamedPair] = []
    for taught, found, i in zip(target.primitives, candidates, matched.tolist(), strict=True):
        if i >= 0:
            here, there = view.both(taught.kind)
            left, right = here.primitives[found.left[i]], there.primitives[found.right[i]]
            pairs.append((f'{target.name}/{taught.name}', *pair_as_taught(taught.shape, left, right)))
    return pairs
