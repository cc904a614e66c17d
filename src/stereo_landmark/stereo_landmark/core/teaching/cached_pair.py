"""A stereo pair under one image processing, with cached results."""

from __future__ import annotations

from stereo_landmark.core.primitives.primitive import Primitive
from stereo_landmark.core.procedure.stereo_view import ImageProcessing, StereoView
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.selectable_primitives import find_same_primitive
from stereo_landmark.core.teaching.teacher import Teacher


class CachedPair:
    """A stereo view with its teacher and a cache of re-detected primitives.

    Args:
        view: stereo view with all kinds of primitives.
        processing: image processing that detected the primitives.
    """

    def __init__(self, view: StereoView, processing: ImageProcessing) -> None:
        self.view = view
        self.teacher = CachingTeacher(view, processing)
        # Keyed by id(); the shape is stored with the result, so that its id is not reused.
        self._same: dict[int, tuple[Primitive, Primitive | None]] = {}

    def find_same(self, shape: Primitive) -> Primitive | None:
        """Return a selected primitive as detected in the left image, None if it is not detected."""
        if id(shape) not in self._same:
            self._same[id(shape)] = shape, find_same_primitive(shape, self.view.left)
        return self._same[id(shape)][1]


class CachingTeacher(Teacher):
    """A teacher that caches the measurement of each primitive."""

    def __init__(self, view: StereoView, processing: ImageProcessing) -> None:
        """Start with an empty cache."""
        super().__init__(view, processing)
        self._measured: dict[int, tuple[Primitive, tuple[Primitive, Primitive] | str]] = {}

    def measure(self, chosen: Primitive) -> tuple[Primitive, Primitive]:
        """Return a primitive refined in both images, as `Teacher.measure` does.

        Raises:
            StereoLandmarkError: it cannot be measured.
        """
        if id(chosen) not in self._measured:
            self._measured[id(chosen)] = chosen, self._measure_or_error(chosen)
        outcome = self._measured[id(chosen)][1]
        if isinstance(outcome, str):
            raise StereoLandmarkError(outcome)
        return outcome

    def _measure_or_error(self, chosen: Primitive) -> tuple[Primitive, Primitive] | str:
        try:
            return super().measure(chosen)
        except StereoLandmarkError as fault:
            return str(fault)
