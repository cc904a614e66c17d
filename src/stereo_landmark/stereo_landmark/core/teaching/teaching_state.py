"""Immutable state of a teaching session."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.primitives.primitive import Primitive, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import ImageProcessing


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
class SelectedPrimitive:
    """A selected primitive of a target.

    Attributes:
        name: name, unique in its target.
        shape: shape detected in the left image when it was selected.
    """

    name: str
    shape: Primitive


@dataclass(frozen=True, eq=False)
class TargetDraft:
    """A target that is being edited.

    Attributes:
        name: name, unique in its place.
        region: region that contains its primitives; None for the whole image.
        primitives: selected primitives, the most reliable first.
        excluded_points: names ``primitive/point`` of points that are not used for the pose.
    """

    name: str
    region: Region | None = None
    primitives: tuple[SelectedPrimitive, ...] = ()
    excluded_points: frozenset[str] = frozenset()


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
    targets: tuple[TargetDraft, ...] = (TargetDraft('target_1'),)
    active: int = 0
    T_map_place: SE2 | None = None

    @property
    def target(self) -> TargetDraft:
        """Active target."""
        return self.targets[self.active]

    @property
    def selection_key(self) -> Hashable:
        """Key of all inputs of the procedure check and of the test; equal keys give equal results."""
        targets = tuple((each.name, each.primitives, each.excluded_points) for each in self.targets)
        return self.pair, self.processing, targets

    @property
    def content_key(self) -> Hashable:
        """Key of the content of a saved place; equal keys mean that nothing has to be saved."""
        return self.name, self.T_map_place, self.selection_key
