"""The primitives of one image."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.edges.settings import EdgeSettings
from stereo_landmark.core.primitives.corner import detect_corners
from stereo_landmark.core.primitives.ellipse import detect_ellipses
from stereo_landmark.core.primitives.parallel_lines import detect_parallel_lines
from stereo_landmark.core.primitives.quadrilateral import detect_quadrilaterals
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.primitives.sides import find_sides
from stereo_landmark.core.procedure.primitive import Kind, Primitive, Tolerances
from stereo_landmark.core.procedure.shape_numbers import centres_of, descriptors_of, numbers_of
from stereo_landmark.core.segments.segments import Segments, follow_segments


@dataclass(frozen=True)
class ImageProcessing:
    """Image processing parameters of a place, from grey images to primitives (paper 3.3b and c)."""

    edges: EdgeSettings = field(default_factory=EdgeSettings)
    primitives: PrimitiveSettings = field(default_factory=PrimitiveSettings)
    tolerances: Tolerances = field(default_factory=Tolerances)


@dataclass(frozen=True)
class DetectedKind:
    """All primitives of one kind in an image.

    Attributes:
        kind: kind of all the primitives.
        primitives: n primitives.
    """

    kind: Kind
    primitives: Sequence[Primitive]

    @cached_property
    def centres(self) -> NDArray[np.float64]:
        """Centres of the primitives, shape (n, 2) [px]."""
        return centres_of(self.kind, self.primitives)

    @cached_property
    def numbers(self) -> NDArray[np.float64]:
        """Shape vectors of the primitives, shape (n, d), see `numbers_of`."""
        return numbers_of(self.kind, self.primitives)

    @cached_property
    def descriptors(self) -> NDArray[np.float64]:
        """Shape descriptors of the primitives, shape (n, DESCRIPTOR_SIZE)."""
        return descriptors_of(self.kind, self.numbers)

    @cached_property
    def tree(self) -> cKDTree:
        """KD-tree of the centres, for radius searches."""
        return cKDTree(self.centres)


@dataclass(frozen=True)
class DetectedScene:
    """Segments and primitives detected in one image.

    Attributes:
        image: grey image, shape (h, w).
        segments: edge segments.
        kinds: detected primitives by kind.
    """

    image: NDArray[np.uint8]
    segments: Segments
    kinds: dict[Kind, DetectedKind]


def detect_scene(
    image: NDArray[np.uint8], processing: ImageProcessing, kinds: Iterable[Kind] = tuple(Kind)
) -> DetectedScene:
    """Detect the primitives of an image.

    Args:
        image: grey image, shape (h, w).
        processing: taught image processing.
        kinds: kinds of primitives to detect.

    Raises:
        StereoLandmarkError: the image has the wrong type or shape, or is too small.
    """
    wanted = set(kinds)
    segments = follow_segments(extract_edges(image, processing.edges), processing.edges)
    found: dict[Kind, DetectedKind] = {}
    if Kind.ELLIPSE in wanted:
        found[Kind.ELLIPSE] = DetectedKind(
            Kind.ELLIPSE, tuple(detect_ellipses(segments, processing.primitives))
        )
    if wanted - {Kind.ELLIPSE}:
        sides = find_sides(segments, processing.primitives)
        for kind, detect in (
            (Kind.QUADRILATERAL, detect_quadrilaterals),
            (Kind.PARALLEL_LINES, detect_parallel_lines),
            (Kind.CORNER, detect_corners),
        ):
            if kind in wanted:
                found[kind] = DetectedKind(kind, detect(sides, processing.primitives))
    return DetectedScene(image, segments, found)
