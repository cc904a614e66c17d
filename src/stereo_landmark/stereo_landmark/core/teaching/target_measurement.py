"""Measures the selected primitives in both images and in 3D (paper 4c)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stereo_landmark.core.primitives.primitive import Primitive
from stereo_landmark.core.procedure.stereo_measurement import NamedPair, stereo_points
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.cached_pair import CachedPair
from stereo_landmark.core.teaching.teacher import TargetSelection
from stereo_landmark.core.teaching.teaching_state import SelectedPrimitive, TargetDraft

NOT_DETECTED = 'it is not detected with this image processing; remove it, or undo the change'


@dataclass(frozen=True, eq=False)
class MeasuredPrimitive:
    """A measured primitive.

    Attributes:
        name: name of the primitive.
        pair: shapes refined in both images, None if it cannot be measured.
        fault: reason why it cannot be measured, otherwise empty.
    """

    name: str
    pair: tuple[Primitive, Primitive] | None
    fault: str


@dataclass(frozen=True, eq=False)
class MeasuredTarget:
    """A measured target.

    Attributes:
        primitives: all primitives in the order of detection.
        points: corresponding points of the measured primitives, named ``primitive/point``.
        coordinates: triangulated points in the place's frame.
    """

    primitives: tuple[MeasuredPrimitive, ...]
    points: StereoPoints
    coordinates: SpatialPoints


def measure_target(draft: TargetDraft, cached: CachedPair) -> MeasuredTarget:
    """Measure the selected primitives of a target in a stereo pair."""
    parts = tuple(_measure_primitive(part, cached) for part in draft.primitives)
    pairs: list[NamedPair] = [(part.name, *part.pair) for part in parts if part.pair is not None]
    points = stereo_points(pairs)
    return MeasuredTarget(parts, points, cached.teacher.coordinates(points))


def make_selection(draft: TargetDraft, cached: CachedPair) -> TargetSelection:
    """Return the selection of a target for teaching.

    Raises:
        StereoLandmarkError: a primitive is not detected any more.
    """
    shapes: dict[str, Primitive] = {}
    for part in draft.primitives:
        shape = cached.find_same(part.shape)
        if shape is None:
            raise StereoLandmarkError(f'target {draft.name}, primitive {part.name}: {NOT_DETECTED}')
        shapes[part.name] = shape
    return TargetSelection(draft.name, shapes, _points(shapes, draft.excluded_points))


def _points(shapes: Mapping[str, Primitive], excluded_points: frozenset[str]) -> tuple[str, ...] | None:
    if not excluded_points:
        return None
    names = stereo_points((name, shape, shape) for name, shape in shapes.items()).names
    return tuple(name for name in names if name not in excluded_points)


def _measure_primitive(part: SelectedPrimitive, cached: CachedPair) -> MeasuredPrimitive:
    shape = cached.find_same(part.shape)
    if shape is None:
        return MeasuredPrimitive(part.name, None, NOT_DETECTED)
    try:
        pair = cached.teacher.measure(shape)
        cached.teacher.coordinates(stereo_points([(part.name, *pair)]))
    except StereoLandmarkError as fault:
        return MeasuredPrimitive(part.name, None, str(fault))
    return MeasuredPrimitive(part.name, pair, '')
