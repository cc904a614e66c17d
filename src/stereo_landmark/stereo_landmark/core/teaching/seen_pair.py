"""One pair of images under one image processing, and what was found out about it: each thing is worked out once."""

from __future__ import annotations

from stereo_landmark.core.procedure.detected_scene import ImageProcessing
from stereo_landmark.core.procedure.primitive import Primitive
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.teaching import Teacher
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.found_primitives import found_again


class SeenPair:
    """A view and its teacher, who looks for a chosen primitive once, however often the page asks.

    Args:
        view: both images, with all kinds of primitives.
        processing: how the primitives were found.
    """

    def __init__(self, view: StereoView, processing: ImageProcessing) -> None:
        self.view = view
        self.teacher = RememberingTeacher(view, processing)
        # By identity; a shape is kept with its answer, so that no other one takes its number.
        self._again: dict[int, tuple[Primitive, Primitive | None]] = {}

    def again(self, shape: Primitive) -> Primitive | None:
        """Return a chosen primitive as it is detected in the left image, None if it is not detected."""
        if id(shape) not in self._again:
            self._again[id(shape)] = shape, found_again(shape, self.view.left)
        return self._again[id(shape)][1]


class RememberingTeacher(Teacher):
    """Measures each primitive once."""

    def __init__(self, view: StereoView, processing: ImageProcessing) -> None:
        """Begin with nothing measured."""
        super().__init__(view, processing)
        self._measured: dict[int, tuple[Primitive, tuple[Primitive, Primitive] | str]] = {}

    def measure(self, chosen: Primitive) -> tuple[Primitive, Primitive]:
        """Return how both images show a primitive, as `Teacher.measure` does.

        Raises:
            StereoLandmarkError: it cannot be measured.
        """
        if id(chosen) not in self._measured:
            self._measured[id(chosen)] = chosen, self._outcome(chosen)
        outcome = self._measured[id(chosen)][1]
        if isinstance(outcome, str):
            raise StereoLandmarkError(outcome)
        return outcome

    def _outcome(self, chosen: Primitive) -> tuple[Primitive, Primitive] | str:
        try:
            return super().measure(chosen)
        except StereoLandmarkError as fault:
            return str(fault)
