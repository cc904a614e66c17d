"""Warnings about a place in batch mode, the same as those on the page."""

from __future__ import annotations

from stereo_landmark.core.procedure.stereo_measurement import invariant_points
from stereo_landmark.core.procedure.teaching import TargetChoice
from stereo_landmark.core.teaching.place_review import not_found_again
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.core.teaching.teaching_state import ChosenPrimitive, TargetDraft


def draft_of(choice: TargetChoice) -> TargetDraft:
    """Return the draft of a target with this selection."""
    parts = tuple(ChosenPrimitive(name, shape) for name, shape in choice.primitives.items())
    points = {f'{part.name}/{point}' for part in parts for point in invariant_points(part.shape)}
    left_out = frozenset() if choice.points is None else frozenset(points - set(choice.points))
    return TargetDraft(choice.name, None, parts, left_out)


def place_remarks(session: TeachingSession) -> list[str]:
    """Return the page's hints for all targets and the undetected targets, one line each, none for a good place.

    Args:
        session: teaching session with all targets selected.

    Raises:
        StereoLandmarkError: a target has no primitives.
    """
    hints = [
        f'target {hint.target}: {hint.text}'
        for draft in session.state.targets
        for hint in session.report(draft).hints
    ]
    return [*not_found_again(session.locate(session.state.pair)), *hints]
