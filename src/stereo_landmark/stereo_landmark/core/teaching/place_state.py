"""Restores the teaching state of a taught place for further editing."""

from __future__ import annotations

from stereo_landmark.core.primitives.primitive import invariant_points
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtTarget
from stereo_landmark.core.teaching.teaching_state import SelectedPrimitive, TargetDraft, TeachingState


def state_from_place(place: TaughtPlace) -> TeachingState:
    """Return the teaching state of a saved place; its stereo pair is number 0."""
    drafts = tuple(_draft(target) for target in place.targets)
    kinds = TeachingState().kinds | {part.kind for target in place.targets for part in target.primitives}
    return TeachingState(place.name, 0, place.processing, kinds, drafts, 0, place.T_map_place)


def _draft(target: TaughtTarget) -> TargetDraft:
    parts = tuple(SelectedPrimitive(part.name, part.shape) for part in target.primitives)
    points = {f'{part.name}/{point}' for part in target.primitives for point in invariant_points(part.shape)}
    return TargetDraft(target.name, None, parts, frozenset(points - set(target.points)))
