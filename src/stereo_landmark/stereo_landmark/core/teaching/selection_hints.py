"""Hints about weak selections: too few points, too narrow, ambiguous."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix, PlaceLocator
from stereo_landmark.core.primitives.primitive import Tolerances, bounding_box, difference, primitive_kind
from stereo_landmark.core.procedure.stereo_view import DetectedScene, StereoView
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints
from stereo_landmark.core.teaching.geometry_hints import check_geometry, find_skewed_shapes
from stereo_landmark.core.teaching.procedure_check import Outcome, TrialRun
from stereo_landmark.core.teaching.target_measurement import MeasuredPrimitive, MeasuredTarget
from stereo_landmark.core.teaching.teaching_state import TargetDraft

POINT_SIGMA_MAX = 0.1
"""Recommended maximum standard deviation of a point [m]."""
PRIMITIVES_RECOMMENDED = 3
"""Recommended number of primitives, so that one may be hidden."""
SIMILAR_MAX = 8
"""Recommended maximum number of shapes similar to the first primitive; more make the search slow."""
BORDER_FRACTION = 0.06
"""Recommended minimum distance from the image border, as a fraction of the image width."""


class Severity(Enum):
    """Severity of a hint."""

    STOP = 'stop'
    WEAK = 'weak'
    NOTE = 'note'


@dataclass(frozen=True)
class Hint:
    """A problem of a target and its remedy.

    Attributes:
        severity: severity; STOP if the place cannot be saved.
        target: name of the target.
        about: name of the primitive or point, empty for the whole target.
        text: message, one sentence.
    """

    severity: Severity
    target: str
    about: str
    text: str


def expected_fix(
    points: StereoPoints, coordinates: SpatialPoints, view: StereoView, settings: LandmarkSettings
) -> PlaceFix | NoPlaceFix:
    """Return the pose at the taught place from the used points of a target, with covariance."""
    return PlaceLocator(view.rig, settings.place).locate(points, coordinates, view.tilt)


def check_selection(
    draft: TargetDraft,
    measured: MeasuredTarget,
    fix: PlaceFix | NoPlaceFix,
    view: StereoView,
    tolerances: Tolerances,
) -> list[Hint]:
    """Return the hints for a target, the most severe first.

    Args:
        draft: edited target.
        measured: measured target.
        fix: expected pose from its used points.
        view: stereo view.
        tolerances: tolerances of the shape comparison.
    """
    hints = [
        *_unmeasured(draft, measured.primitives),
        *_geometry(draft, measured, fix),
        *_uncertain_points(draft, measured.coordinates),
        *_skewed(draft, measured),
        *_near_border(draft, measured.primitives, view),
        *_similar_shapes(draft, view.left, tolerances),
    ]
    return sorted(hints, key=lambda hint: list(Severity).index(hint.severity))


def check_trials(target: str, trials: Sequence[TrialRun]) -> Iterator[Hint]:
    """Yield hints about failed trial runs of a target's procedure tree."""
    for trial in trials:
        if trial.outcome is Outcome.FOUND:
            continue
        without = f'without {" and ".join(trial.hidden)} ' if trial.hidden else ''
        severity = (Severity.STOP, Severity.WEAK, Severity.NOTE)[min(len(trial.hidden), 2)]
        match trial.outcome:
            case Outcome.AMBIGUOUS:
                text = f'{without}several poses match about equally well ({trial.detail}); add a distinctive primitive'
            case Outcome.WRONG_POSE:
                text = f'{without}a wrong pose is found ({trial.detail}); add a distinctive primitive'
                severity = Severity.STOP
            case _:
                text = f'{without}it is not detected ({trial.detail}); add a primitive'
        yield Hint(severity, target, trial.hidden[0] if len(trial.hidden) == 1 else '', text)


def _unmeasured(draft: TargetDraft, parts: Sequence[MeasuredPrimitive]) -> Iterator[Hint]:
    for part in parts:
        if part.pair is None:
            yield Hint(Severity.STOP, draft.name, part.name, part.fault)


def _geometry(draft: TargetDraft, measured: MeasuredTarget, fix: PlaceFix | NoPlaceFix) -> Iterator[Hint]:
    if not draft.primitives:
        yield Hint(
            Severity.STOP,
            draft.name,
            '',
            'no primitive is selected; draw a region and click on shapes, or remove the target',
        )
        return
    if isinstance(fix, NoPlaceFix):
        text = f'{fix.reason.value} ({fix.detail}); select more points, farther apart or nearer'
        yield Hint(Severity.STOP, draft.name, '', text)
        return
    if len(draft.primitives) < PRIMITIVES_RECOMMENDED:
        count = len(draft.primitives)
        text = (
            f'too few primitives: {count}, select {PRIMITIVES_RECOMMENDED} or more, since one may be hidden'
        )
        yield Hint(Severity.WEAK, draft.name, '', text)
    used = measured.coordinates.select(fix.names).positions
    for text in check_geometry(used, fix):
        yield Hint(Severity.WEAK, draft.name, '', text)


def _uncertain_points(draft: TargetDraft, points: SpatialPoints) -> Iterator[Hint]:
    for name, covariance in zip(points.names, points.covariances, strict=True):
        sigma = math.sqrt(float(np.linalg.eigvalsh(covariance)[-1]))
        if sigma > POINT_SIGMA_MAX and name not in draft.excluded_points:
            text = f'{name} has a standard deviation of {100.0 * sigma:.0f} cm; exclude the point'
            yield Hint(Severity.WEAK, draft.name, name, text)


def _skewed(draft: TargetDraft, measured: MeasuredTarget) -> Iterator[Hint]:
    shapes = {part.name: part.pair[0] for part in measured.primitives if part.pair is not None}
    for name, text in find_skewed_shapes(shapes, measured.coordinates):
        yield Hint(Severity.WEAK, draft.name, name, text)


def _near_border(draft: TargetDraft, parts: Sequence[MeasuredPrimitive], view: StereoView) -> Iterator[Hint]:
    if len(parts) < 2 or parts[0].pair is None:
        return
    width, height = view.rig.left.width, view.rig.left.height
    boxes = [bounding_box(shape) for shape in parts[0].pair]
    distance = min(float(min(low.min(), *([width, height] - high))) for low, high in boxes)
    if distance < BORDER_FRACTION * width:
        name = parts[0].name
        text = (
            f'{name} is {max(distance, 0.0):.0f} px from the border and soon out of view; move it to the end'
        )
        yield Hint(Severity.NOTE, draft.name, name, text)


def _similar_shapes(draft: TargetDraft, scene: DetectedScene, tolerances: Tolerances) -> Iterator[Hint]:
    if not draft.primitives:
        return
    first = draft.primitives[0]
    detected = scene.kinds[primitive_kind(first.shape)].primitives
    similar = sum(difference(each, first.shape, tolerances) <= 1.0 for each in detected)
    if similar > SIMILAR_MAX:
        text = f'{similar} shapes in the image are similar to {first.name}; put a rarer primitive first'
        yield Hint(Severity.NOTE, draft.name, first.name, text)
