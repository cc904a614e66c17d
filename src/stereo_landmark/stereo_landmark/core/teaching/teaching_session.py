"""A teaching session: edits with undo history, and the results computed from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.edges.segments import Segments, trace_segments
from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.place.place_locator import NoPlaceFix, PlaceFix
from stereo_landmark.core.primitives.primitive import PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import ImageProcessing, StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.cached_pair import CachedPair
from stereo_landmark.core.teaching.procedure_check import TrialRun, check_procedure
from stereo_landmark.core.teaching.selectable_primitives import SelectablePrimitive, selectable_primitives
from stereo_landmark.core.teaching.selection_hints import Hint, check_selection, expected_fix
from stereo_landmark.core.teaching.target_measurement import MeasuredTarget, make_selection, measure_target
from stereo_landmark.core.teaching.teaching_state import TargetDraft, TeachingState
from stereo_landmark.core.teaching.undo_history import UndoHistory

CACHED_PAIRS_MAX = 4
"""Number of cached pairs, so that undo and redo are fast."""


@dataclass(frozen=True, eq=False)
class TargetReport:
    """Results for a target.

    Attributes:
        measured: primitives and points in both images and in 3D.
        fix: expected pose from its used points, with covariance.
        hints: hints about weak selections.
    """

    measured: MeasuredTarget
    fix: PlaceFix | NoPlaceFix
    hints: list[Hint]


class TeachingSession:
    """A teaching session with its history.

    Args:
        load_images: returns the stereo pair of a number, always the same for the same number.
        rig: stereo cameras of the images.
        state: initial state, None for an empty place.
        settings: localization settings for tests, None for the defaults.
    """

    def __init__(
        self,
        load_images: Callable[[int], StereoImages],
        rig: StereoRig,
        state: TeachingState | None = None,
        settings: LandmarkSettings | None = None,
    ) -> None:
        self.history = UndoHistory(state or TeachingState())
        self._load_images = load_images
        self.rig = rig
        self.settings = settings or LandmarkSettings()
        self._cached_pairs: dict[tuple[int, ImageProcessing], CachedPair] = {}

    @property
    def state(self) -> TeachingState:
        """Current state."""
        return self.history.current

    @property
    def images(self) -> StereoImages:
        """Stereo pair used for teaching."""
        return self._load_images(self.state.pair)

    def apply(self, edit: Callable[[TeachingState], TeachingState], gesture: str = '') -> None:
        """Apply an edit; a rejected edit changes nothing, and an edit without a change is not recorded.

        Args:
            edit: one of :mod:`stereo_landmark.core.teaching.edits`, with all but its first argument bound.
            gesture: name of a gesture whose edits are undone together.

        Raises:
            StereoLandmarkError: the edit is not possible.
        """
        state = edit(self.state)
        if state is not self.state:
            self.history.push(state, gesture)

    def segments(self, image: NDArray[np.uint8]) -> Segments:
        """Return the edge segments of an image with the current image processing (paper 4a)."""
        settings = self.state.processing.edges
        return trace_segments(extract_edges(image, settings), settings)

    @property
    def view(self) -> StereoView:
        """Detected primitives of both images.

        Raises:
            StereoLandmarkError: an image has another size than the calibration.
        """
        return self._cached.view

    def selectable(self) -> list[SelectablePrimitive]:
        """Return the primitives that can be selected (paper 4b)."""
        return selectable_primitives(self.view, self.state.kinds, self.state.target.region)

    def selected_name(self, found: SelectablePrimitive) -> str | None:
        """Return the name of a detected primitive in the target, None if it is not selected."""
        cached = self._cached
        for part in self.state.target.primitives:
            if cached.find_same(part.shape) is found.shape:
                return part.name
        return None

    def toggle(self, kind: PrimitiveKind, number: int) -> None:
        """Select a primitive of the left image, or remove it from the target if it is selected.

        Raises:
            StereoLandmarkError: the number does not exist.
        """
        among = self.view.left.kinds[kind].primitives
        if not 0 <= number < len(among):
            raise StereoLandmarkError(
                f'there is no {kind.value} of number {number}; select one that is shown'
            )
        shape = among[number]
        name = self.selected_name(SelectablePrimitive(kind, number, shape, None))
        self.apply(
            (lambda state: edits.add_primitive(state, shape))
            if name is None
            else (lambda state: edits.remove_primitive(state, name))
        )

    def report(self, draft: TargetDraft) -> TargetReport:
        """Return the results for a target (paper 4c)."""
        measured = measure_target(draft, self._cached)
        used = [name not in draft.excluded_points for name in measured.points.names]
        points = measured.points.subset(np.array(used, dtype=np.bool_))
        fix = expected_fix(points, measured.coordinates, self.view, self.settings)
        hints = check_selection(draft, measured, fix, self.view, self.state.processing.tolerances)
        return TargetReport(measured, fix, hints)

    def place(self) -> TaughtPlace:
        """Return the taught place.

        Raises:
            StereoLandmarkError: a target has no primitives.
        """
        return self._teach_targets(self.state.targets)

    def draft(self) -> TaughtPlace:
        """Return the place without targets that are still empty.

        Raises:
            StereoLandmarkError: all targets are empty, or a selected primitive cannot be measured.
        """
        return self._teach_targets([target for target in self.state.targets if target.primitives])

    def _teach_targets(self, targets: Sequence[TargetDraft]) -> TaughtPlace:
        state, cached = self.state, self._cached
        selections = [make_selection(draft, cached) for draft in targets]
        return cached.teacher.teach(state.name, selections, state.T_map_place)

    def check(self, number: int) -> list[TrialRun]:
        """Test the procedure tree of a target on the images used for teaching (paper 4d).

        Raises:
            StereoLandmarkError: a target has no primitives.
        """
        place, draft = self.place(), self.state.targets[number]
        parts = measure_target(draft, self._cached).primitives
        pairs = {part.name: part.pair for part in parts if part.pair is not None}
        search = self.settings.search
        return list(check_procedure(place, place.targets[number], pairs, self.view, search))

    def locate(self, pair: int) -> LandmarkFix | NoLandmarkFix:
        """Localize the robot in another stereo pair with the current selections.

        Raises:
            StereoLandmarkError: a target has no primitives, or the images have another size.
        """
        images = self._load_images(pair)
        localizer = LandmarkLocalizer([self.place()], self.settings)
        return localizer.locate(images.left, images.right, images.tilt)

    @property
    def _cached(self) -> CachedPair:
        state = self.state
        key = state.pair, state.processing
        if key not in self._cached_pairs:
            images = self.images
            _check_size(images, self.rig)
            left, right = (detect_scene(image, state.processing) for image in (images.left, images.right))
            self._cached_pairs[key] = CachedPair(
                StereoView(left, right, self.rig, images.tilt), state.processing
            )
            for old in list(self._cached_pairs)[:-CACHED_PAIRS_MAX]:
                del self._cached_pairs[old]
        return self._cached_pairs[key]


def _check_size(images: StereoImages, rig: StereoRig) -> None:
    for name, image in (('left', images.left), ('right', images.right)):
        if image.shape != (rig.left.height, rig.left.width):
            raise StereoLandmarkError(
                f'the {name} image is {image.shape[1]} x {image.shape[0]} px, the calibration is for '
                f'{rig.left.width} x {rig.left.height} px; calibrate at the resolution in use'
            )
