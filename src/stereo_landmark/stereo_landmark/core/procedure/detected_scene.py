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
from stereo_landmark.core.primitives.line_segments import fit_line_segments
from stereo_landmark.core.primitives.parallel_lines import detect_parallel_lines
from stereo_landmark.core.primitives.quadrilateral import detect_quadrilaterals
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.procedure.primitive import Primitive, PrimitiveKind, Tolerances
from stereo_landmark.core.procedure.shape_vectors import primitive_centres, shape_descriptors, shape_vectors
from stereo_landmark.core.segments.segments import Segments, trace_segments


@dataclass(frozen=True)
class ImageProcessing:
    """Image processing parameters of a place, from grey images to primitives (paper 3.3b and c)."""

    edges: EdgeSettings = field(default_factory=EdgeSettings)
    primitives: PrimitiveSettings = field(default_factory=PrimitiveSettings)
    tolerances: Tolerances = field(default_factory=Tolerances)


@dataclass(frozen=True)
class DetectedPrimitives:
    """All primitives of one kind in an image.

    Attributes:
        kind: kind of all the primitives.
        primitives: n primitives.
    """

    kind: PrimitiveKind
    primitives: Sequence[Primitive]

    @cached_property
    def centres(self) -> NDArray[np.float64]:
        """Centres of the primitives, shape (n, 2) [px]."""
        return primitive_centres(self.kind, self.primitives)

    @cached_property
    def shape_vectors(self) -> NDArray[np.float64]:
        """Shape vectors of the primitives, shape (n, d), see `shape_vectors`."""
        return shape_vectors(self.kind, self.primitives)

    @cached_property
    def descriptors(self) -> NDArray[np.float64]:
        """Shape descriptors of the primitives, shape (n, DESCRIPTOR_SIZE)."""
        return shape_descriptors(self.kind, self.shape_vectors)

    @cached_property
    def kd_tree(self) -> cKDTree:
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
    kinds: dict[PrimitiveKind, DetectedPrimitives]


def detect_scene(
    image: NDArray[np.uint8],
    processing: ImageProcessing,
    kinds: Iterable[PrimitiveKind] = tuple(PrimitiveKind),
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
    segments = trace_segments(extract_edges(image, processing.edges), processing.edges)
    found: dict[PrimitiveKind, DetectedPrimitives] = {}
    if PrimitiveKind.ELLIPSE in wanted:
        found[PrimitiveKind.ELLIPSE] = DetectedPrimitives(
            PrimitiveKind.ELLIPSE, tuple(detect_ellipses(segments, processing.primitives))
        )
    if wanted - {PrimitiveKind.ELLIPSE}:
        sides = fit_line_segments(segments, processing.primitives)
        for kind, detect in (
            (PrimitiveKind.QUADRILATERAL, detect_quadrilaterals),
            (PrimitiveKind.PARALLEL_LINES, detect_parallel_lines),
            (PrimitiveKind.CORNER, detect_corners),
        ):
            if kind in wanted:
                found[kind] = DetectedPrimitives(kind, detect(sides, processing.primitives))
    return DetectedScene(image, segments, found)
