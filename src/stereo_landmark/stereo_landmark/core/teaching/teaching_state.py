"""All that the engineer has chosen so far."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose
from stereo_landmark.core.procedure.detected_scene import ImageProcessing
from stereo_landmark.core.procedure.primitive import Kind, Primitive


@dataclass(frozen=True)
class Region:
    """A rectangle of the left image in which a target lies (paper 4b) [px]."""

    left: float
    top: float
    right: float
    bottom: float

    def holds(self, points: NDArray[np.float64]) -> bool:
        """Return whether all points, shape (n, 2), are inside [px]."""
        low, high = points.min(axis=0), points.max(axis=0)
        return bool(
            self.left <= low[0] and self.top <= low[1] and high[0] <= self.right and high[1] <= self.bottom
        )


@dataclass(frozen=True, eq=False)
class ChosenPrimitive:
    """A primitive of a target.

    Attributes:
        name: unique in its target.
        shape: as it was detected in the left image when it was chosen.
    """

    name: str
    shape: Primitive


@dataclass(frozen=True, eq=False)
class TargetDraft:
    """A target that is being described.

    Attributes:
        name: unique in its place.
        region: where its primitives are looked for; None for the whole image.
        primitives: chosen ones, the surest first.
        left_out: ``primitive/point`` that the pose shall not be made of.
    """

    name: str
    region: Region | None = None
    primitives: tuple[ChosenPrimitive, ...] = ()
    left_out: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class TeachingState:
    """A place that is being taught; each step of the engineer makes a new one.

    Attributes:
        name: of the place.
        pair: number of the pair of images that it is taught from.
        processing: of the images (paper 4a).
        kinds: of primitives that are shown and can be chosen.
        targets: one or more.
        active: number of the target that is worked on.
        T_map_place: where the place is in the map, None where nobody told.
    """

    name: str = 'place_1'
    pair: int = 0
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    kinds: frozenset[Kind] = frozenset({Kind.ELLIPSE, Kind.QUADRILATERAL})
    targets: tuple[TargetDraft, ...] = (TargetDraft('target_1'),)
    active: int = 0
    T_map_place: PlanarPose | None = None

    @property
    def target(self) -> TargetDraft:
        """The one that is worked on."""
        return self.targets[self.active]

    @property
    def choice(self) -> Hashable:
        """What a check of the procedure tree and a test depend on; equal where nothing of that was changed."""
        targets = tuple((each.name, each.primitives, each.left_out) for each in self.targets)
        return self.pair, self.processing, targets

    @property
    def work(self) -> Hashable:
        """All that a saved place holds; equal where nothing was changed that is worth saving."""
        return self.name, self.T_map_place, self.choice
