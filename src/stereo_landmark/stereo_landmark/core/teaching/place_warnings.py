"""Warnings about a place in batch mode, the same as those on the page."""

from __future__ import annotations

from stereo_landmark.core.primitives.primitive import invariant_points
from stereo_landmark.core.teaching.place_check import undetected_targets
from stereo_landmark.core.teaching.teacher import TargetSelection
from stereo_landmark.core.teaching.teaching_session import TeachingSession
from stereo_landmark.core.teaching.teaching_state import SelectedPrimitive, TargetDraft


def make_draft(selection: TargetSelection) -> TargetDraft:
    """Return the draft of a target with this selection."""
    parts = tuple(SelectedPrimitive(name, shape) for name, shape in selection.primitives.items())
    points = {f'{part.name}/{point}' for part in parts for point in invariant_points(part.shape)}
    excluded_points = frozenset() if selection.points is None else frozenset(points - set(selection.points))
    return TargetDraft(selection.name, None, parts, excluded_points)


def find_place_warnings(session: TeachingSession) -> list[str]:
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
    return [*undetected_targets(session.locate(session.state.pair)), *hints]
