"""A teaching session: edits with undo and redo, and the results computed from them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stereo_landmark.core.arrays import GreyImage
from stereo_landmark.core.edges.edges import Segments, extract_edges, trace_segments
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix
from stereo_landmark.core.pair.camera_pair import check_size
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching import edits
from stereo_landmark.core.teaching.edits import TeachingState
from stereo_landmark.core.teaching.hints import TargetReport, report_target
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.procedure_check import TrialRun, check_procedure
from stereo_landmark.core.teaching.teacher import Teacher

CACHED_PAIRS_MAX = 4
"""Number of cached pairs, so that undo and redo are fast."""


@dataclass(frozen=True, eq=False)
class SelectablePrimitive:
    """A selectable primitive of the left image.

    Attributes:
        kind: kind of the primitive.
        number: index among the primitives of its kind.
        shape: detected shape.
        depth: depth of its centre [m], None without a match in the right image.
        fault: why it cannot be measured, empty if it can.
    """

    kind: PrimitiveKind
    number: int
    shape: Primitive
    depth: float | None
    fault: str


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
        self._states = [state or TeachingState()]
        self._now, self._gesture = 0, ''
        self._load_images = load_images
        self.rig = rig
        self.settings = settings or LandmarkSettings()
        self._teachers: dict[tuple[int, ImageProcessing], Teacher] = {}

    @property
    def state(self) -> TeachingState:
        """Current state."""
        return self._states[self._now]

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier state."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone state."""
        return self._now + 1 < len(self._states)

    def apply(self, edit: Callable[[TeachingState], TeachingState], gesture: str = '') -> None:
        """Apply an edit; a rejected edit changes nothing, and an edit without a change is not recorded.

        Args:
            edit: one of :mod:`stereo_landmark.core.teaching.edits`, with all but its first argument bound.
            gesture: name of a gesture, such as one drag of a slider, whose edits are undone together; empty for none.

        Raises:
            StereoLandmarkError: the edit is not possible.
        """
        state = edit(self.state)
        if state is self.state:
            return
        if gesture and gesture == self._gesture:
            self._states[self._now] = state
            return
        self._states[self._now + 1 :] = [state]
        self._now, self._gesture = self._now + 1, gesture

    def undo(self) -> None:
        """Return to the previous state, if there is one."""
        self._now, self._gesture = max(self._now - 1, 0), ''

    def redo(self) -> None:
        """Return to the undone state, if there is one."""
        self._now, self._gesture = min(self._now + 1, len(self._states) - 1), ''

    @property
    def images(self) -> StereoImages:
        """Stereo pair used for teaching."""
        return self._load_images(self.state.pair)

    def segments(self, image: GreyImage) -> Segments:
        """Return the edge segments of an image with the current image processing (paper 4a)."""
        settings = self.state.processing.edges
        return trace_segments(extract_edges(image, settings), settings)

    @property
    def view(self) -> StereoView:
        """Detected primitives of both images.

        Raises:
            StereoLandmarkError: an image has another size than the calibration.
        """
        return self._teacher.view

    def selectable(self) -> list[SelectablePrimitive]:
        """Return the primitives that can be selected: of the shown kinds, in the target's region (paper 4b)."""
        state, view = self.state, self.view
        region = state.target.region
        return [
            SelectablePrimitive(kind, number, shape, _depth(view, kind, number), self._teacher.fault(shape))
            for kind in sorted(state.kinds, key=list(PrimitiveKind).index)
            for number, shape in enumerate(view.left.kinds[kind].primitives)
            if region is None or region.contains(np.vstack(shape.outline()))
        ]

    def selected_name(self, found: Primitive) -> str | None:
        """Return the name of a detected primitive in the target, None if it is not selected."""
        teacher, selected = self._teacher, self.state.target.primitives.items()
        return next((name for name, shape in selected if teacher.find_same(shape) is found), None)

    def toggle(self, kind: PrimitiveKind, number: int) -> None:
        """Select a primitive of the left image, or remove it from the target if it is selected.

        Raises:
            StereoLandmarkError: the number does not exist.
        """
        among = self.view.left.kinds[kind].primitives
        if not 0 <= number < len(among):
            raise StereoLandmarkError(f'there is no {kind.value} of number {number}; select one that is shown')
        shape = among[number]
        name = self.selected_name(shape)
        self.apply(
            (lambda state: edits.add_primitive(state, shape))
            if name is None
            else (lambda state: edits.remove_primitive(state, name))
        )

    def remove_refused(self) -> None:
        """Remove all primitives that cannot be measured from all targets, in one edit."""
        measured = [self.report(target).measured for target in self.state.targets]
        refused = [[name for name, pair in each.items() if isinstance(pair, str)] for each in measured]
        self.apply(lambda state: edits.remove_primitives(state, refused))

    def report(self, target: TargetSelection) -> TargetReport:
        """Return the results for a target (paper 4c)."""
        teacher = self._teacher
        shapes = {name: teacher.find_same(shape) for name, shape in target.primitives.items()}
        return report_target(target, shapes, teacher, self.settings.place)

    def place(self) -> TaughtPlace:
        """Return the taught place, without primitives that cannot be measured.

        Raises:
            StereoLandmarkError: a target has no primitives, or none that can be measured.
        """
        return self._teach_targets(self._teacher.drop_refused(self.state.targets)[0])

    @property
    def left_out(self) -> list[str]:
        """A line for each primitive that cannot be measured: the place is taught without it."""
        return self._teacher.drop_refused(self.state.targets)[1]

    def draft(self) -> TaughtPlace:
        """Return the place without targets that are still empty.

        Raises:
            StereoLandmarkError: all targets are empty, or none of the primitives can be measured.
        """
        return self._teach_targets(
            self._teacher.drop_refused(target for target in self.state.targets if target.primitives)[0]
        )

    def _teach_targets(self, targets: Sequence[TargetSelection]) -> TaughtPlace:
        return self._teacher.teach(self.state.name, targets, self.state.T_map_place)

    def check(self, number: int) -> list[TrialRun]:
        """Test the procedure tree of a target on the images used for teaching (paper 4d).

        Raises:
            StereoLandmarkError: a target has no primitives, or none that can be measured.
        """
        place, selection = self.place(), self.state.targets[number]
        target = next((each for each in place.targets if each.name == selection.name), None)
        if target is None:
            raise StereoLandmarkError(f'target {selection.name}: none of its shapes can be used; select others')
        measured = self.report(selection).measured
        pairs = {name: pair for name, pair in measured.items() if not isinstance(pair, str)}
        return list(check_procedure(place, target, pairs, self.view, self.settings.search))

    def locate(self, pair: int, tilt: tuple[float, float] | None = None) -> LandmarkFix | NoLandmarkFix:
        """Localize the robot in another stereo pair with the current selections.

        Args:
            pair: number of the pair.
            tilt: roll and pitch of the robot [rad], None for those of the pair.

        Raises:
            StereoLandmarkError: a target has no primitives, or the images have another size.
        """
        images = self._load_images(pair)
        localizer = LandmarkLocalizer([self.place()], self.settings)
        return localizer.locate(images.left, images.right, images.tilt if tilt is None else tilt)

    @property
    def _teacher(self) -> Teacher:
        """Teacher of the present pair and image processing; the latest ones are cached."""
        state = self.state
        key = state.pair, state.processing
        if key not in self._teachers:
            images = self.images
            check_size(images.left, self.rig.left, 'the left image')
            check_size(images.right, self.rig.right, 'the right image')
            left, right = (detect_scene(image, state.processing) for image in (images.left, images.right))
            view = StereoView(left, right, self.rig, images.tilt)
            self._teachers[key] = Teacher(view, state.processing)
            for old in list(self._teachers)[:-CACHED_PAIRS_MAX]:
                del self._teachers[old]
        return self._teachers[key]


def _depth(view: StereoView, kind: PrimitiveKind, number: int) -> float | None:
    match = int(view.match_indices(kind)[number])
    if match < 0:
        return None
    here, there = view.detected_pair(kind)
    pixels = np.concatenate([here.centres[number], there.centres[match]])
    return float(view.rig.left.fx * view.rig.baseline / view.rig.disparities(pixels))
