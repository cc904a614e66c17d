"""Tests the procedure tree of a target on the images used for teaching (paper 4d)."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.procedure.detected_scene import DetectedKind, DetectedScene
from stereo_landmark.core.procedure.primitive import Primitive
from stereo_landmark.core.procedure.settings import SearchSettings
from stereo_landmark.core.procedure.sighting import NoSightingReason, TargetSighting
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.target_search import TargetSearch
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget
from stereo_landmark.core.teaching.outline import bounds_of

_NEAR = 0.1
"""Maximum pose error on the taught images [m, rad]."""
_BEYOND = 2.0
"""Margin around a hidden primitive within which others are hidden, too [px]."""


class Outcome(Enum):
    """Outcome of a search."""

    FOUND = 'found'
    AMBIGUOUS = 'ambiguous'
    MISSED = 'missed'
    MISTAKEN = 'mistaken'


@dataclass(frozen=True)
class TrialRun:
    """A search with some primitives hidden.

    Attributes:
        hidden: names of the hidden primitives.
        outcome: outcome of the search.
        detail: numbers for the message.
    """

    hidden: tuple[str, ...]
    outcome: Outcome
    detail: str


def check_procedure(
    place: TaughtPlace,
    target: TaughtTarget,
    pairs: dict[str, tuple[Primitive, Primitive]],
    view: StereoView,
    settings: SearchSettings,
) -> Iterator[TrialRun]:
    """Yield the outcomes with nothing hidden, with each primitive hidden, and with the first ones of the order hidden.

    Args:
        place: place with the target.
        target: tested target.
        pairs: primitives of the target in both images.
        view: stereo view used for teaching.
        settings: search settings.
    """
    names = [primitive.name for primitive in target.primitives]
    trials: list[tuple[str, ...]] = [(), *((name,) for name in names)]
    most = int(len(names) * (1.0 - settings.seen_min))
    trials += [tuple(names[:count]) for count in range(2, most + 1)]
    for hidden in trials if len(names) > 1 else trials[:1]:
        seen = _covered(view, [pairs[name] for name in hidden]) if hidden else view
        yield _trial(TargetSearch(place, settings), target, seen, hidden)


def _trial(search: TargetSearch, target: TaughtTarget, view: StereoView, hidden: tuple[str, ...]) -> TrialRun:
    answer = search.search(target, view)
    if not isinstance(answer, TargetSighting):
        ambiguous = answer.reason is NoSightingReason.AMBIGUOUS
        return TrialRun(hidden, Outcome.AMBIGUOUS if ambiguous else Outcome.MISSED, answer.detail)
    x, y, _, yaw = answer.state
    if max(np.hypot(x, y), abs(yaw)) > _NEAR:
        return TrialRun(hidden, Outcome.MISTAKEN, f'pose error {np.hypot(x, y):.2f} m')
    return TrialRun(hidden, Outcome.FOUND, f'log-likelihood ratio {answer.evidence:.1f}')


def _covered(view: StereoView, pairs: Collection[tuple[Primitive, Primitive]]) -> StereoView:
    """Return the view without some primitives and those inside them."""
    left = _without(view.left, [left for left, _ in pairs])
    right = _without(view.right, [right for _, right in pairs])
    return StereoView(left, right, view.rig, view.tilt)


def _without(scene: DetectedScene, hidden: Collection[Primitive]) -> DetectedScene:
    kinds = {}
    for kind, detected in scene.kinds.items():
        gone = np.zeros(len(detected.primitives), dtype=np.bool_)
        for primitive in hidden:
            low, high = bounds_of(primitive)
            inside = (detected.centres >= low - _BEYOND) & (detected.centres <= high + _BEYOND)
            gone |= inside.all(axis=1)
        kept = tuple(p for p, is_gone in zip(detected.primitives, gone, strict=True) if not is_gone)
        kinds[kind] = DetectedKind(kind, kept)
    return DetectedScene(scene.image, scene.segments, kinds)
