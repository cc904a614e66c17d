"""Tries the procedure tree of a target on the images that it was taught from (paper 4d)."""

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
"""Seen from where it was taught, a target tells a pose no farther from there [m, rad]."""
_BEYOND = 2.0
"""What lies less beyond the outline of a hidden primitive is hidden too [px]."""


class Outcome(Enum):
    """Of a search."""

    FOUND = 'found'
    AMBIGUOUS = 'ambiguous'
    MISSED = 'missed'
    MISTAKEN = 'mistaken'


@dataclass(frozen=True)
class TrialRun:
    """A search with some primitives hidden.

    Attributes:
        hidden: their names.
        outcome: what came out.
        detail: numbers to it.
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
    """Yield what is found with nothing hidden, with each primitive hidden, and with the first ones, path by path.

    Args:
        place: with the target.
        target: that is tried.
        pairs: its primitives in both images.
        view: both images that it was taught from.
        settings: of the search.
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
        return TrialRun(hidden, Outcome.MISTAKEN, f'{np.hypot(x, y):.2f} m away')
    return TrialRun(hidden, Outcome.FOUND, f'evidence {answer.evidence:.1f}')


def _covered(view: StereoView, pairs: Collection[tuple[Primitive, Primitive]]) -> StereoView:
    """Return the view without some primitives and what is inside them."""
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
