"""What the chosen primitives measure in both images and in space (paper 4c)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stereo_landmark.core.place.stereo_points import SpatialPoints, StereoPoints
from stereo_landmark.core.procedure.primitive import Primitive
from stereo_landmark.core.procedure.stereo_measurement import NamedPair, stereo_points
from stereo_landmark.core.procedure.teaching import TargetChoice
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.seen_pair import SeenPair
from stereo_landmark.core.teaching.teaching_state import ChosenPrimitive, TargetDraft

LOST = 'it is not found with this image processing; take it out, or take the change back'


@dataclass(frozen=True, eq=False)
class MeasuredPrimitive:
    """A chosen primitive.

    Attributes:
        name: of it.
        pair: how both images show it, None where it cannot be measured.
        fault: why not, else empty.
    """

    name: str
    pair: tuple[Primitive, Primitive] | None
    fault: str


@dataclass(frozen=True, eq=False)
class MeasuredTarget:
    """A target as it is measured.

    Attributes:
        primitives: all of them, in their order.
        points: all corresponding points of those that can be measured, named ``primitive/point``.
        coordinates: of the points, in the place's frame.
    """

    primitives: tuple[MeasuredPrimitive, ...]
    points: StereoPoints
    coordinates: SpatialPoints


def measure_draft(draft: TargetDraft, seen: SeenPair) -> MeasuredTarget:
    """Measure what was chosen of a target in a pair of images."""
    parts = tuple(_measured(part, seen) for part in draft.primitives)
    pairs: list[NamedPair] = [(part.name, *part.pair) for part in parts if part.pair is not None]
    points = stereo_points(pairs)
    return MeasuredTarget(parts, points, seen.teacher.coordinates(points))


def choice_of(draft: TargetDraft, seen: SeenPair) -> TargetChoice:
    """Return what is taught of a target.

    Raises:
        StereoLandmarkError: a primitive is not found any more.
    """
    shapes: dict[str, Primitive] = {}
    for part in draft.primitives:
        shape = seen.again(part.shape)
        if shape is None:
            raise StereoLandmarkError(f'target {draft.name}, primitive {part.name}: {LOST}')
        shapes[part.name] = shape
    return TargetChoice(draft.name, shapes, _points(shapes, draft.left_out))


def _points(shapes: Mapping[str, Primitive], left_out: frozenset[str]) -> tuple[str, ...] | None:
    if not left_out:
        return None
    names = stereo_points((name, shape, shape) for name, shape in shapes.items()).names
    return tuple(name for name in names if name not in left_out)


def _measured(part: ChosenPrimitive, seen: SeenPair) -> MeasuredPrimitive:
    shape = seen.again(part.shape)
    if shape is None:
        return MeasuredPrimitive(part.name, None, LOST)
    try:
        pair = seen.teacher.measure(shape)
        seen.teacher.coordinates(stereo_points([(part.name, *pair)]))
    except StereoLandmarkError as fault:
        return MeasuredPrimitive(part.name, None, str(fault))
    return MeasuredPrimitive(part.name, pair, '')
