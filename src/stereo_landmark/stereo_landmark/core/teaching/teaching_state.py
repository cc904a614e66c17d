"""Immutable state of a teaching session, and the selection that makes a target (paper 4b and c)."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import Primitive, PrimitiveKind, point_names
from stereo_landmark.core.procedure.stereo_view import ImageProcessing
from stereo_landmark.core.procedure.taught_place import TaughtPlace


@dataclass(frozen=True)
class Region:
    """A rectangle of the left image that contains a target (paper 4b) [px]."""

    left: float
    top: float
    right: float
    bottom: float

    def contains(self, points: NDArray[np.float64]) -> bool:
        """Return whether all points, shape (n, 2), are inside [px]."""
        low, high = points.min(axis=0), points.max(axis=0)
        return bool(
            self.left <= low[0] and self.top <= low[1] and high[0] <= self.right and high[1] <= self.bottom
        )


@dataclass(frozen=True, eq=False)
class TargetSelection:
    """The primitives and points selected for a target.

    Attributes:
        name: name, unique in its place.
        primitives: selected primitives of the left image by name, the most reliable first.
        points: names ``primitive/point`` of the points used for the pose; None for all.
        region: region that contains its primitives; None for the whole image.
    """

    name: str
    primitives: Mapping[str, Primitive] = field(default_factory=dict)
    points: tuple[str, ...] | None = None
    region: Region | None = None

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


@dataclass(frozen=True, eq=False)
class TeachingState:
    """State of a place that is being taught; each edit returns a new state.

    Attributes:
        name: name of the place.
        pair: number of the stereo pair used for teaching.
        processing: image processing (paper 4a).
        kinds: kinds of primitives that are shown and can be selected.
        targets: one or more targets.
        active: index of the active target.
        T_map_place: pose of the place in the map, None if unknown.
    """

    name: str = 'place_1'
    pair: int = 0
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    kinds: frozenset[PrimitiveKind] = frozenset({PrimitiveKind.ELLIPSE, PrimitiveKind.QUADRILATERAL})
    targets: tuple[TargetSelection, ...] = (TargetSelection('target_1'),)
    active: int = 0
    T_map_place: SE2 | None = None

    @property
    def target(self) -> TargetSelection:
        """Active target."""
        return self.targets[self.active]

    @property
    def selection_key(self) -> Hashable:
        """Key of all inputs of the procedure check and of the test; equal keys give equal results."""
        targets = tuple((each.name, tuple(each.primitives.items()), each.points) for each in self.targets)
        return self.pair, self.processing, targets

    @property
    def content_key(self) -> Hashable:
        """Key of the content of a saved place; equal keys mean that nothing has to be saved."""
        return self.name, self.T_map_place, self.selection_key


def state_from_place(place: TaughtPlace) -> TeachingState:
    """Return the teaching state of a saved place for further editing; its stereo pair is number 0."""
    selections = []
    for target in place.targets:
        selection = TargetSelection(target.name, {part.name: part.shape for part in target.primitives})
        names = point_names(selection.primitives.items())
        selections.append(selection.excluding(set(names) - set(target.points)))
    kinds = TeachingState().kinds | {part.kind for target in place.targets for part in target.primitives}
    return TeachingState(place.name, 0, place.processing, kinds, tuple(selections), 0, place.T_map_place)
