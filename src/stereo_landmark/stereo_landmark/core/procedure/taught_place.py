"""What is taught of a place (paper 3.3): targets of primitives, their points, and what is around them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.place.stereo_points import SpatialPoints
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.procedure.detected_scene import ImageProcessing
from stereo_landmark.core.procedure.primitive import Kind, Primitive, kind_of, size_of


@dataclass(frozen=True)
class TaughtPrimitive:
    """One primitive.

    Attributes:
        name: unique in its target.
        shape: as the left camera saw it; its covariance is zero.
        position: of its centre in the place's frame, shape (3,) [m].
        normal: of the wall that a circle is on, shape (3,), in the place's frame; None for what is no circle.
    """

    name: str
    shape: Primitive
    position: NDArray[np.float64]
    normal: NDArray[np.float64] | None = None

    @property
    def kind(self) -> Kind:
        """What it is."""
        return kind_of(self.shape)

    @property
    def size(self) -> float:
        """How large the left camera saw it [px]."""
        return size_of(self.shape)


@dataclass(frozen=True)
class TaughtTarget:
    """An object to look for, described by primitives (paper 3.2).

    Attributes:
        name: unique in its place.
        primitives: in the order of their detection, the surest first (paper 3.3c).
        points: names of the corresponding points, ``primitive/point`` (paper 3.3d).
    """

    name: str
    primitives: tuple[TaughtPrimitive, ...]
    points: tuple[str, ...]


@dataclass(frozen=True)
class TaughtPlace:
    """A place. Its frame is the level base frame of the robot when it was taught.

    Attributes:
        name: of the place, also of its frame.
        rig: the cameras that it was taught with (paper 3.3a).
        processing: of the images (paper 3.3b).
        targets: what to look for (paper 3.3c and d).
        coordinates: of the points, named ``target/primitive/point`` (paper 3.3e).
        surroundings: other primitives around the targets; they tell a target from its like.
        T_map_place: where the place is in the map, None where nobody told.
        images: from which it was taught, None where they are not at hand.
    """

    name: str
    rig: StereoRig
    targets: tuple[TaughtTarget, ...]
    coordinates: SpatialPoints
    surroundings: tuple[TaughtPrimitive, ...] = ()
    processing: ImageProcessing = field(default_factory=ImageProcessing)
    T_map_place: PlanarPose | None = None
    images: StereoImages | None = field(default=None, compare=False, repr=False)

    @property
    def kinds(self) -> set[Kind]:
        """The kinds of primitives to look for."""
        taught = [primitive for target in self.targets for primitive in target.primitives]
        return {primitive.kind for primitive in (*taught, *self.surroundings)}
