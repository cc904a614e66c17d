"""Detects primitives in windows of one image, each processed on its own (paper 3.2): the paper mode."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.edges.edges import SIDE_MIN
from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.primitive import (
    ImageProcessing,
    Primitive,
    PrimitiveKind,
    bounding_box,
    primitive_kind,
    shape_differences,
    shape_vectors,
)
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.stereo_view import DetectedPrimitives, detect_scene

GROWTH_MAX = 1.3
"""Growth of a primitive since teaching up to which its window shows it wholly."""
MARGIN = 8.0
"""Margin of a window for the edge filter and noise removal [px]."""
GRID = 64.0
"""Windows are rounded outwards to this grid, so that those of neighbouring candidates are processed once [px]."""


class _Window(NamedTuple):
    """A processed window: its upper left and lower right corner, shape (2, 2) [px], and its primitives."""

    corners: Ints
    detected: DetectedPrimitives


class WindowDetector:
    """Detects primitives in windows of an image.

    Args:
        image: grey image, shape (h, w).
        processing: image processing that was taught for the target.
    """

    def __init__(self, image: GreyImage, processing: ImageProcessing) -> None:
        self._image, self._processing = image, processing
        self._windows: list[_Window] = []

    def find(self, taught: Primitive, low: Floats, high: Floats) -> list[tuple[Primitive, float]]:
        """Return the primitives similar to a taught one whose centres are in a window, with their shape differences.

        Args:
            taught: taught primitive.
            low: upper left corner of the window, shape (2,) [px].
            high: lower right corner of the window, shape (2,) [px].
        """
        # The image processing sees the window and as much around it as the primitive needs.
        reach = GROWTH_MAX * (bounding_box(taught) - taught.centre)
        first, last = (low + reach[0] - MARGIN) // GRID, (high + reach[1] + MARGIN) // GRID + 1.0
        corners = np.clip(GRID * np.array([first, last]), 0, self._image.shape[::-1]).astype(np.int64)
        if (corners[1] - corners[0] < SIDE_MIN).any():
            return []
        kind = primitive_kind(taught)
        window = self._process(kind, corners)
        offset = window.corners[0].astype(np.float64)
        centres = window.detected.centres + offset
        inside = np.flatnonzero(((centres >= low) & (centres <= high)).all(axis=1))
        vectors = window.detected.shape_vectors[inside], shape_vectors(kind, [taught])
        (differences,) = shape_differences(kind, *vectors, self._processing.tolerances)
        return [
            (_shift(window.detected.primitives[i], offset), float(difference))
            for i, difference in zip(inside.tolist(), differences, strict=True)
            if difference <= 1.0
        ]

    def _process(self, kind: PrimitiveKind, corners: Ints) -> _Window:
        """Return a processed window that contains the corners; each part of the image is processed once a kind."""
        for known in self._windows:
            low, high = known.corners
            if known.detected.kind is kind and (low <= corners[0]).all() and (high >= corners[1]).all():
                return known
        (left, top), (right, bottom) = corners
        crop = np.ascontiguousarray(self._image[top:bottom, left:right])
        window = _Window(corners, detect_scene(crop, self._processing, (kind,)).kinds[kind])
        self._windows.append(window)
        return window


def _shift(primitive: Primitive, offset: Floats) -> Primitive:
    """Return a primitive of a window in the coordinates of the image."""
    match primitive:
        case Quadrilateral():
            return replace(primitive, corners=primitive.corners + offset)
        case Corner():
            return replace(primitive, vertex=primitive.vertex + offset)
        case _:
            return replace(primitive, centre=primitive.centre + offset)
