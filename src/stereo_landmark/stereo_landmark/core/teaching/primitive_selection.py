"""The selection that makes a target (paper 4b and c), by mouse or by position, size and order in a lesson."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    Tolerances,
    difference,
    point_names,
    primitive_size,
)
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, DetectedScene
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

SAME_CENTRE, SAME_SIZE = 3.0, 0.15
"""Maximum distance [px] and relative size difference of a primitive after a change of the image processing."""
DISTANCE_MAX = 20.0
"""Maximum distance of the selected primitive from the given pixel [px]."""
ANY_SIZE = (0.0, math.inf)


class SortOrder(Enum):
    """Sort order of the primitives of a region."""

    LEFT_TO_RIGHT = 'left_to_right'
    RIGHT_TO_LEFT = 'right_to_left'
    TOP_TO_BOTTOM = 'top_to_bottom'
    BOTTOM_TO_TOP = 'bottom_to_top'
    LARGEST_FIRST = 'largest_first'


_SORT_KEYS: dict[SortOrder, Callable[[Primitive], float]] = {
    SortOrder.LEFT_TO_RIGHT: lambda primitive: float(primitive.centre[0]),
    SortOrder.RIGHT_TO_LEFT: lambda primitive: -float(primitive.centre[0]),
    SortOrder.TOP_TO_BOTTOM: lambda primitive: float(primitive.centre[1]),
    SortOrder.BOTTOM_TO_TOP: lambda primitive: -float(primitive.centre[1]),
    SortOrder.LARGEST_FIRST: lambda primitive: -primitive_size(primitive),
}


@dataclass(frozen=True)
class NearestSelection:
    """Selects the primitive nearest to a pixel.

    Attributes:
        kind: kind of the primitive.
        pixel: u and v near its centre [px].
        size_range: smallest and largest `primitive_size`, e.g. to separate the inner from the outer edge of a rim [px].
        name: name of the selected primitive; the kind and a number if empty.
    """

    kind: PrimitiveKind
    pixel: tuple[float, float]
    size_range: tuple[float, float] = ANY_SIZE
    name: str = ''

    def find(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitive nearest to the pixel.

        Raises:
            StereoLandmarkError: no primitive is near.
        """
        candidates = _with_size(scene, self.kind, self.size_range)
        centres = np.array([primitive.centre for primitive in candidates]).reshape(-1, 2)
        offsets = np.hypot(*(centres - self.pixel).T)
        if not len(offsets) or offsets.min() > DISTANCE_MAX:
            where = f'{self.pixel[0]:g}, {self.pixel[1]:g}'
            nearest = 'there is none of this size in the image'
            if len(offsets):
                u, v = centres[int(offsets.argmin())]
                nearest = f'the nearest is at {u:.0f}, {v:.0f}'
            raise StereoLandmarkError(f'no {self.kind.value} near {where}, {nearest}; correct near')
        return [candidates[int(offsets.argmin())]]


@dataclass(frozen=True)
class RegionSelection:
    """Selects all primitives of a kind in a region.

    Attributes:
        kind: kind of the primitives.
        region: left, top, right, bottom of the rectangle that contains their centres [px].
        size_range: smallest and largest size [px].
        order: sort order.
        count: exact number of selected primitives, the first in the order; None for all.
        name: name prefix of the selected primitives; the kind if empty.
    """

    kind: PrimitiveKind
    region: tuple[float, float, float, float]
    size_range: tuple[float, float] = ANY_SIZE
    order: SortOrder = SortOrder.LEFT_TO_RIGHT
    count: int | None = None
    name: str = ''

    def find(self, scene: DetectedScene) -> list[Primitive]:
        """Return the primitives in the sort order.

        Raises:
            StereoLandmarkError: there are fewer than requested, or none.
        """
        left, top, right, bottom = self.region
        found = [
            primitive
            for primitive in _with_size(scene, self.kind, self.size_range)
            if left <= primitive.centre[0] <= right and top <= primitive.centre[1] <= bottom
        ]
        if len(found) < (self.count or 1):
            raise StereoLandmarkError(
                f'{len(found)} of kind {self.kind.value} in the region, {self.count or 1} are needed; '
                'correct region or image_processing'
            )
        return sorted(found, key=_SORT_KEYS[self.order])[: self.count]


Selection = NearestSelection | RegionSelection


def select_primitives(selections: list[Selection], scene: DetectedScene) -> dict[str, Primitive]:
    """Return the selected primitives by name, in the order of the selections.

    Named primitives keep their names; others are numbered, ``meter 1``, ``meter 2``.

    Raises:
        StereoLandmarkError: a selection matches nothing, or a name or a primitive is selected twice.
    """
    named: dict[str, Primitive] = {}
    for selection in selections:
        for number, primitive in enumerate(selection.find(scene), start=1):
            if any(primitive is other for other in named.values()):
                raise StereoLandmarkError(
                    f'{selection.kind.value} at {primitive.centre[0]:.0f}, {primitive.centre[1]:.0f} selected twice; '
                    'remove one of the entries'
                )
            named[_make_name(selection, number, named)] = primitive
    return named


def _with_size(scene: DetectedScene, kind: PrimitiveKind, size_range: tuple[float, float]) -> list[Primitive]:
    return [each for each in scene.kinds[kind].primitives if size_range[0] <= primitive_size(each) <= size_range[1]]


def _make_name(selection: Selection, number: int, taken: dict[str, Primitive]) -> str:
    if isinstance(selection, NearestSelection) and selection.name:
        name = selection.name
    elif selection.name:
        name = f'{selection.name} {number}'
    else:
        number = 1 + sum(key.startswith(f'{selection.kind.value} ') for key in taken)
        name = f'{selection.kind.value} {number}'
    if name in taken:
        raise StereoLandmarkError(f'two primitives are called {name}; names must be unique')
    return name


@dataclass(frozen=True)
class Region:
    """A rectangle of the left image that contains a target (paper 4b) [px]."""

    left: float
    top: float
    right: float
    bottom: float

    def contains(self, points: Floats) -> bool:
        """Return whether all points, shape (n, 2), are inside [px]."""
        low, high = points.min(axis=0), points.max(axis=0)
        return bool(self.left <= low[0] and self.top <= low[1] and high[0] <= self.right and high[1] <= self.bottom)


@dataclass(frozen=True, eq=False)
class TargetSelection:
    """The primitives and points selected for a target.

    Attributes:
        name: name, unique in its place.
        primitives: selected primitives of the left image by name, the most reliable first.
        points: names ``primitive/point`` of the points used for the pose; None for all.
        region: region that contains its primitives; None for the whole image.
        processing: image processing of its own (paper 3.2); None for that of the place.
    """

    name: str
    primitives: Mapping[str, Primitive] = field(default_factory=dict)
    points: tuple[str, ...] | None = None
    region: Region | None = None
    processing: ImageProcessing | None = None

    def uses(self, point: str) -> bool:
        """Return whether a point is used for the pose."""
        return self.points is None or point in self.points

    @property
    def excluded_points(self) -> frozenset[str]:
        """Points that are not used for the pose."""
        return frozenset(name for name in point_names(self.primitives.items()) if not self.uses(name))

    def excluding(self, points: Collection[str]) -> TargetSelection:
        """Return the selection that uses all but these points, in the order of its primitives."""
        names = point_names(self.primitives.items())
        used = tuple(name for name in names if name not in points)
        return replace(self, points=None if used == names else used)


def find_same(shape: Primitive, detected: DetectedPrimitives) -> Primitive | None:
    """Return the primitive that is the same as one of another image processing, None if there is none."""
    if any(each is shape for each in detected.primitives):
        return shape
    if not detected.primitives:
        return None

    def misfit(each: Primitive) -> float:
        distance = float(np.hypot(*(each.centre - shape.centre)))
        return distance + abs(primitive_size(each) - primitive_size(shape))

    near = [detected.primitives[i] for i in detected.kd_tree.query_ball_point(shape.centre, SAME_CENTRE)]
    similar = [
        each
        for each in near
        if abs(primitive_size(each) / primitive_size(shape) - 1.0) < SAME_SIZE
        and difference(each, shape, Tolerances()) <= 1.0
    ]
    return min(similar, key=misfit, default=None)
