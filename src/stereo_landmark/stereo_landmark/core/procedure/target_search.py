"""Looks for a taught target in a pair of images (paper 3.4, fig. 6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.reprojection_fit import fit_reprojection
from stereo_landmark.core.place.settings import PlaceSettings
from stereo_landmark.core.place.stereo_points import StereoPoints
from stereo_landmark.core.place.stereo_rig import MEASURED
from stereo_landmark.core.procedure.circles import centre_motion
from stereo_landmark.core.procedure.evidence import Evidence
from stereo_landmark.core.procedure.prediction import expected_pixels
from stereo_landmark.core.procedure.primitive import refined_pair
from stereo_landmark.core.procedure.rematch import Rematch
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.sighting import NoSightingReason, NoTargetSighting, TargetSighting
from stereo_landmark.core.procedure.stereo_candidates import StereoCandidates, stereo_candidates
from stereo_landmark.core.procedure.stereo_measurement import NamedPair, pair_as_taught, stereo_points
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.suppositions import suppose
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget

DETECTED_SIGMA = 0.7
"""How well a detected primitive is known before it is measured in the grey image [px]."""
COARSE = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)
APART = 15.0
"""Poses from which a primitive is expected this far away are different [px]."""
REMATCH_WINDOWS = 10.0, 4.0
"""Within which primitives are matched again, each time followed by a fit [px]."""
DEPTH_MIN = 0.3
DEPTH_SHARE = 0.3
"""Detected depths are off by up to this share."""


@dataclass(frozen=True)
class _Reading:
    """A supposed pose, fitted to the primitives that speak for it."""

    state: NDArray[np.float64]
    pairs: list[NamedPair]
    evidence: float


class TargetSearch:
    """Looks for the targets of one place.

    Args:
        place: as taught.
        settings: None for the defaults.
    """

    def __init__(self, place: TaughtPlace, settings: SearchSettings | None = None) -> None:
        self._place = place
        self._settings = settings or SearchSettings()

    def search(self, target: TaughtTarget, view: StereoView) -> TargetSighting | NoTargetSighting:
        """Look for a target.

        Args:
            target: of the place.
            view: both images, with the place's kinds of primitives.
        """
        positions = np.array([taught.position for taught in target.primitives])
        best = self._verdict(target, self._readings(target, positions, view), positions, view)
        if isinstance(best, NoTargetSighting):
            return best
        images = view.left.image, view.right.image
        measured: list[NamedPair] = []
        for name, left, right in best.pairs:
            pair = refined_pair(left, right, images)
            if pair is not None:
                measured.append((name, *pair))
        found = tuple(name for name, _, _ in measured)
        points = _without_motion(stereo_points(measured), target, best.state, view)
        return TargetSighting(target.name, best.state, points, found, best.evidence)

    def _readings(
        self, target: TaughtTarget, positions: NDArray[np.float64], view: StereoView
    ) -> list[_Reading]:
        """Return the poses that may be, those first for which most speaks."""
        candidates = self._candidates(target, view)
        evidence = self._evidence(view)
        rematch = Rematch(self._place, target, view)
        least = max(2.0, self._settings.seen_min * len(target.primitives))
        readings: list[_Reading] = []
        for supposed in suppose(positions, candidates, view, self._settings):
            pairs = _pairs(target, supposed.matched, candidates, view)
            state = self._fitted(supposed.state, pairs, view)
            if state is not None:
                for window in REMATCH_WINDOWS:
                    nearer = rematch.pairs(state, window)
                    fitted = self._fitted(state, nearer, view) if len(nearer) >= least else None
                    if fitted is not None:
                        state, pairs = fitted, nearer
                readings.append(_Reading(state, pairs, evidence.weigh(state)))
        return sorted(readings, key=lambda reading: -reading.evidence)

    def _candidates(self, target: TaughtTarget, view: StereoView) -> list[StereoCandidates]:
        """Return what may be each primitive of the target, at a depth at which it may be."""
        tolerances, reach = self._place.processing.tolerances, self._settings.reach
        found = []
        for taught in target.primitives:
            distance = float(np.linalg.norm(taught.position - view.camera.position))
            slack = reach + DEPTH_SHARE * distance
            depths = max(DEPTH_MIN, distance * np.cos(self._settings.turn) - slack), distance + slack
            found.append(stereo_candidates(taught.shape, view, depths, tolerances))
        return found

    def _evidence(self, view: StereoView) -> Evidence:
        place = self._place
        expected = [primitive for target in place.targets for primitive in target.primitives]
        return Evidence([*expected, *place.surroundings], view, place.processing.tolerances, self._settings)

    def _fitted(
        self, start: NDArray[np.float64], pairs: list[NamedPair], view: StereoView
    ) -> NDArray[np.float64] | None:
        """Return the pose that fits matched primitives as they were detected, None where they tell none."""
        seen = stereo_points(pairs)
        noise = np.tile(DETECTED_SIGMA**2 * np.eye(MEASURED), (len(seen), 1, 1))
        seen = StereoPoints(seen.names, seen.pixels, noise)
        if len(seen) < 2:
            return None
        taught = self._place.coordinates.selected(seen.names)
        fit = fit_reprojection(seen, taught, view.rig, np.concatenate([start, view.tilt]), COARSE)
        return None if fit is None else fit.state[:4]

    def _verdict(
        self,
        target: TaughtTarget,
        readings: list[_Reading],
        positions: NDArray[np.float64],
        view: StereoView,
    ) -> _Reading | NoTargetSighting:
        """Return the reading that can be trusted, or why there is none."""
        if not readings:
            detail = f'{len(target.primitives)} primitives were looked for'
            return NoTargetSighting(target.name, NoSightingReason.NO_CANDIDATE, detail)
        best = readings[0]
        if best.evidence < self._settings.evidence_min:
            detail = f'evidence {best.evidence:.1f}, {self._settings.evidence_min:g} is needed'
            return NoTargetSighting(target.name, NoSightingReason.NO_EVIDENCE, detail)
        states = np.array([reading.state for reading in readings])
        pixels = expected_pixels(states, positions, view)[..., :2]
        apart = np.nanmax(np.hypot(*(pixels - pixels[:1]).transpose(2, 0, 1)), axis=1)
        others = [reading for reading, far in zip(readings, apart, strict=True) if far > APART]
        if others and best.evidence - others[0].evidence < self._settings.margin:
            detail = f'evidence {best.evidence:.1f} and {others[0].evidence:.1f}'
            return NoTargetSighting(target.name, NoSightingReason.AMBIGUOUS, detail)
        return best


def _without_motion(
    points: StereoPoints, target: TaughtTarget, state: NDArray[np.float64], view: StereoView
) -> StereoPoints:
    """Return points of which the centres of circles are where they were taught, not where they appear to be."""
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
    """Return the primitives of both images that a supposition matched."""
    pairs: list[NamedPair] = []
    for taught, found, i in zip(target.primitives, candidates, matched.tolist(), strict=True):
        if i >= 0:
            here, there = view.both(taught.kind)
            left, right = here.primitives[found.left[i]], there.primitives[found.right[i]]
            pairs.append((f'{target.name}/{taught.name}', *pair_as_taught(taught.shape, left, right)))
    return pairs
