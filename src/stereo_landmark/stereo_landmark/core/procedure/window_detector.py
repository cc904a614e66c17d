"""Detects the primitives of a target in its window of one image (paper 3.2, 3.4): the paper mode.

Only the part of the image in which the target can be is processed, only for its kinds of primitives, with its own image
processing. Processing each small window of the procedure tree on its own would take longer, because they overlap.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.edges.edges import SIDE_MIN
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    bounding_box,
    primitive_kind,
    shape_differences,
    shape_sizes,
    shape_vectors,
    shift,
)
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, detect_scene

GROWTH_MAX = 1.3
"""Growth of a primitive since teaching up to which the window shows it wholly."""
MARGIN = 8.0
"""Margin of the window for the edge filter and noise removal [px]."""


class SearchRegion(NamedTuple):
    """The region in which the centre of a primitive can be.

    Attributes:
        taught: taught shape.
        low: upper left corner, shape (2,) [px].
        high: lower right corner, shape (2,) [px].
    """

    taught: Primitive
    low: Floats
    high: Floats


class Detection(NamedTuple):
    """A detected primitive that is similar to a taught one.

    Attributes:
        detected: primitives of its kind.
        number: its index among them.
        offset: offset of the window in which they are detected, shape (2,) [px].
        centre: centre in the image, in the complex plane [px].
        size: size [px].
        difference: difference from the taught shape, 0 for none, 1 at the tolerance.
    """

    detected: DetectedPrimitives
    number: int
    offset: Floats
    centre: complex
    size: float
    difference: float

    @property
    def primitive(self) -> Primitive:
        """The primitive in the coordinates of the image."""
        return shift(self.detected.primitives[self.number], self.offset)


class WindowDetector:
    """Detects the primitives of a target in its window of an image.

    Args:
        image: grey image, shape (h, w).
        processing: image processing that was taught for the target.
        regions: regions of its primitives.
    """

    def __init__(self, image: GreyImage, processing: ImageProcessing, regions: Sequence[SearchRegion]) -> None:
        reaches = [GROWTH_MAX * (bounding_box(each.taught) - each.taught.centre) for each in regions]
        low = np.min([each.low + reach[0] for each, reach in zip(regions, reaches, strict=True)], axis=0)
        high = np.max([each.high + reach[1] for each, reach in zip(regions, reaches, strict=True)], axis=0)
        corners = np.clip(np.rint([low - MARGIN, high + MARGIN]), 0, image.shape[::-1])
        (left, top), (right, bottom) = corners.astype(int).tolist()
        if min(right - left, bottom - top) < SIDE_MIN:
            self._similar = [(np.empty((0, 2)), list[Detection]()) for _ in regions]
            return
        window, kinds = image[top:bottom, left:right], {primitive_kind(each.taught) for each in regions}
        scene = detect_scene(np.ascontiguousarray(window), processing, kinds)
        self._similar = [
            _find_similar(each, scene.kinds[primitive_kind(each.taught)], processing, corners[0]) for each in regions
        ]

    def find(self, index: int, centre: complex = 0.0j, radius: float = np.inf) -> list[Detection]:
        """Return the detections of a primitive within a radius of a predicted centre in the complex plane [px]."""
        centres, detections = self._similar[index]
        is_near = np.hypot(centres[:, 0] - centre.real, centres[:, 1] - centre.imag) <= radius
        return [detections[i] for i in np.flatnonzero(is_near).tolist()]


def _find_similar(
    region: SearchRegion, detected: DetectedPrimitives, processing: ImageProcessing, offset: Floats
) -> tuple[Floats, list[Detection]]:
    """Return the primitives in a region that are similar to the taught one, and their centres, shape (n, 2) [px]."""
    centres = detected.centres + offset
    vectors = detected.shape_vectors, shape_vectors(detected.kind, [region.taught])
    (differences,) = shape_differences(detected.kind, *vectors, processing.tolerances)
    is_inside = ((centres >= region.low) & (centres <= region.high)).all(axis=1)
    chosen = np.flatnonzero(is_inside & (differences <= 1.0))
    sizes = shape_sizes(detected.kind, detected.shape_vectors)
    detections = [
        Detection(detected, i, offset, complex(*centres[i]), float(sizes[i]), float(differences[i]))
        for i in chosen.tolist()
    ]
    return centres[chosen], detections
