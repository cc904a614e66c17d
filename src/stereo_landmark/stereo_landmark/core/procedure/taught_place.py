"""Taught data of a place (paper 3.3): targets made of primitives, their points, and context landmarks."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from shirube_core.geometry import SE2
from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    primitive_kind,
    primitive_size,
)
from stereo_landmark.core.stereo import SpatialPoints, StereoImages, StereoRig


@dataclass(frozen=True)
class TaughtPrimitive:
    """One taught primitive.

    Attributes:
        name: name, unique in its target.
        shape: shape in the taught left image, with zero covariance.
        position: centre in the place's frame, shape (3,) [m].
        normal: normal of the wall of a circle, shape (3,), in the place's frame; None for other kinds.
    """

    name: str
    shape: Primitive
    position: Floats
    normal: Floats | None = None

    @property
    def kind(self) -> PrimitiveKind:
        """Kind of the primitive."""
        return primitive_kind(self.shape)

    @property
    def size(self) -> float:
        """Size in the taught left image [px]."""
        return primitive_size(self.shape)


@dataclass(frozen=True)
class TaughtTarget:
    """An object to detect, described by primitives (paper 3.2).

    Attributes:
        name: name, unique in its place.
        primitives: primitives in the order of detection, the most reliable first (paper 3.3c).
        points: names of the corresponding points, ``primitive/point`` (paper 3.3d).
    """

    name: str
    primitives: tuple[TaughtPrimitive, ...]
    points: tuple[str, ...]

    @property
    def positions(self) -> Floats:
        """Centres of the primitives in the place's frame, shape (k, 3) [m]."""
        return np.array([primitive.position for primitive in self.primitives])


@dataclass(frozen=True)
class TaughtPlace:
    """A taught place. Its frame is the gravity-aligned base frame of the robot at teaching time.

    Attributes:
        name: name of the place and of its frame.
        rig: stereo cameras used for teaching (paper 3.3a).
        processing: image processing parameters (paper 3.3b).
        targets: objects to detect (paper 3.3c and d).
        coordinates: taught points, named ``target/primitive/point`` (paper 3.3e).
        context_landmarks: context landmarks: other primitives around the targets, which disambiguate similar targets.
        T_map_place: pose of the place in the map, None if unknown.
        images: images used for teaching, None if not available.
    """

    name: str
    rig: StereoRig
    targets: tuple[TaughtTarget, ...]
    coordinates: SpatialPoints
    context_landmarks: tuple[TaughtPrimitive, ...] = ()
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    T_map_place: SE2 | None = None
    images: StereoImages | None = field(default=None, compare=False, repr=False)

    @property
    def kinds(self) -> set[PrimitiveKind]:
        """Kinds of primitives to detect."""
        taught = [primitive for target in self.targets for primitive in target.primitives]
        return {primitive.kind for primitive in (*taught, *self.context_landmarks)}
