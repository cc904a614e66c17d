"""Tests the procedure tree of a target on the images used for teaching (paper 4d)."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.primitives.primitive import Primitive, bounding_box
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, DetectedScene, StereoView
from stereo_landmark.core.procedure.target_search import NoDetectionReason, TargetDetection, TargetSearch
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget
from stereo_landmark.core.settings import SearchSettings
from stereo_landmark.core.teaching.hints import Hint, Severity

_POSE_TOLERANCE = 0.1
"""Maximum pose error on the taught images [m, rad]."""
_HIDDEN_MARGIN = 2.0
"""Margin around a hidden primitive within which others are hidden, too [px]."""


class Outcome(Enum):
    """Outcome of a search."""

    FOUND = 'found'
    AMBIGUOUS = 'ambiguous'
    NOT_FOUND = 'not_found'
    WRONG_POSE = 'wrong_pose'


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
    """Yield the outcomes with nothing hidden, with each primitive hidden, and with the first ones hidden."""
    names = [primitive.name for primitive in target.primitives]
    trials: list[tuple[str, ...]] = [(), *((name,) for name in names)]
    hidden_max = int(len(names) * (1.0 - settings.found_fraction_min))
    trials += [tuple(names[:count]) for count in range(2, hidden_max + 1)]
    for hidden in trials if len(names) > 1 else trials[:1]:
        visible = _hide_primitives(view, [pairs[name] for name in hidden]) if hidden else view
        yield _run_trial(TargetSearch(place, settings), target, visible, hidden)


def check_trials(target: str, trials: Sequence[TrialRun]) -> Iterator[Hint]:
    """Yield hints about failed trial runs of a target's procedure tree."""
    for trial in trials:
        if trial.outcome is Outcome.FOUND:
            continue
        without = f'without {" and ".join(trial.hidden)} ' if trial.hidden else ''
        severity = (Severity.STOP, Severity.WEAK, Severity.NOTE)[min(len(trial.hidden), 2)]
        match trial.outcome:
            case Outcome.AMBIGUOUS:
                text = f'{without}it could be confused with another position; add a shape that makes the difference'
            case Outcome.WRONG_POSE:
                text = f'{without}a wrong position is found ({trial.detail}); add a shape that makes the difference'
                severity = Severity.STOP
            case _:
                text = f'{without}it is not found again; add a shape'
        yield Hint(severity, target, trial.hidden[0] if len(trial.hidden) == 1 else '', text)


def _run_trial(search: TargetSearch, target: TaughtTarget, view: StereoView, hidden: tuple[str, ...]) -> TrialRun:
    answer = search.search(target, view)
    if not isinstance(answer, TargetDetection):
        ambiguous = answer.reason is NoDetectionReason.AMBIGUOUS
        return TrialRun(hidden, Outcome.AMBIGUOUS if ambiguous else Outcome.NOT_FOUND, answer.detail)
    x, y, _, yaw = answer.state
    if max(np.hypot(x, y), abs(yaw)) > _POSE_TOLERANCE:
        return TrialRun(hidden, Outcome.WRONG_POSE, f'pose error {np.hypot(x, y):.2f} m')
    return TrialRun(hidden, Outcome.FOUND, f'log-likelihood ratio {answer.log_likelihood_ratio:.1f}')


def _hide_primitives(view: StereoView, pairs: Collection[tuple[Primitive, Primitive]]) -> StereoView:
    """Return the view without some primitives and those inside them."""
    left = _remove_primitives(view.left, [left for left, _ in pairs])
    right = _remove_primitives(view.right, [right for _, right in pairs])
    return StereoView(left, right, view.rig, view.tilt)


def _remove_primitives(scene: DetectedScene, hidden: Collection[Primitive]) -> DetectedScene:
    kinds = {}
    for kind, detected in scene.kinds.items():
        is_hidden = np.zeros(len(detected.primitives), dtype=np.bool_)
        for primitive in hidden:
            low, high = bounding_box(primitive)
            inside = (detected.centres >= low - _HIDDEN_MARGIN) & (detected.centres <= high + _HIDDEN_MARGIN)
            is_hidden |= inside.all(axis=1)
        kept = tuple(p for p, is_gone in zip(detected.primitives, is_hidden, strict=True) if not is_gone)
        kinds[kind] = DetectedPrimitives(kind, kept)
    return DetectedScene(scene.image, scene.segments, kinds)
