"""Segments: linked edge points with the attributes that the paper lists (3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.edges.edges import Edges
from stereo_landmark.core.edges.settings import EdgeSettings
from stereo_landmark.core.segments.chains import extract_chains, index_points, link_points
from stereo_landmark.core.segments.polyline import polyline_vertices

NEIGHBOUR_DISTANCE_MAX = 6.0
"""Largest distance from an end point to a neighbouring segment [px]."""


@dataclass(frozen=True)
class Segments:
    """The segments of an image, concatenated; the bright side is on the right of each.

    Attributes:
        points: subpixel edge points of all segments, shape (n, 2) [px].
        gradients: image gradients, which point to the bright side, shape (n, 2) [grey levels / px].
        starts: start of each segment in ``points``, shape (m + 1,).
        closed: whether the segment returns to its first point, shape (m,).
        vertex_indices: indices of the polyline vertices in ``points``, ends included, shape (k,).
        vertex_starts: start of each segment in ``vertex_indices``, shape (m + 1,).
        index: index in ``points`` of the edge in each pixel, -1 where there is none, shape (h, w).
    """

    points: NDArray[np.float64]
    gradients: NDArray[np.float64]
    starts: NDArray[np.int32]
    closed: NDArray[np.bool_]
    vertex_indices: NDArray[np.int32]
    vertex_starts: NDArray[np.int32]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.closed)

    def segment_points(self, segment: int) -> NDArray[np.float64]:
        """Return the edge points of one segment in order, shape (n, 2) [px]."""
        return self.points[self.starts[segment] : self.starts[segment + 1]]

    def segment_polyline(self, segment: int) -> NDArray[np.float64]:
        """Return the polyline vertices of one segment in order, ends included, shape (k, 2) [px]."""
        return self.points[self.vertex_indices[self.vertex_starts[segment] : self.vertex_starts[segment + 1]]]

    def segment_chain_code(self, segment: int) -> NDArray[np.uint8]:
        """Return the Freeman chain code of one segment: 0 right, 2 down, 4 left, 6 up.

        A step over a gap of one pixel is coded as two steps.
        """
        pixels = np.rint(self.segment_points(segment)).astype(np.int64)
        steps = np.diff(pixels, axis=0)
        counts = np.abs(steps).max(axis=1, initial=0)
        parts = np.repeat(np.arange(len(steps)), counts)
        substeps = np.arange(len(parts)) - np.repeat(np.cumsum(counts) - counts, counts)
        fractions = np.column_stack([substeps, substeps + 1]) / counts[parts, None]
        unit = np.rint(steps[parts] * fractions[:, 1:]) - np.rint(steps[parts] * fractions[:, :1])
        return (np.rint(np.arctan2(unit[:, 1], unit[:, 0]) / (0.25 * np.pi)).astype(np.int64) % 8).astype(
            np.uint8
        )

    @cached_property
    def end_points(self) -> NDArray[np.float64]:
        """First and last point of each segment, shape (m, 2, 2) [px]."""
        return np.stack([self.points[self.starts[:-1]], self.points[self.starts[1:] - 1]], axis=1)

    @cached_property
    def lengths(self) -> NDArray[np.float64]:
        """Length of each segment along its polyline, shape (m,) [px]."""
        vertices = self.points[self.vertex_indices]
        steps = np.append(np.hypot(*np.diff(vertices, axis=0).T), 0.0)
        steps[self.vertex_starts[1:] - 1] = 0.0
        return np.add.reduceat(steps, self.vertex_starts[:-1]) if len(self) else np.empty(0)

    @cached_property
    def chords(self) -> NDArray[np.float64]:
        """Distance between both ends of each segment, shape (m,) [px]."""
        return np.hypot(*(self.end_points[:, 1] - self.end_points[:, 0]).T)

    @cached_property
    def neighbours(self) -> list[list[int]]:
        """Indices of the segments with an end point near another, for each segment, in rising order.

        An attribute of the paper's segments (3.4). The detectors here search end points with their own radii.
        """
        near: list[set[int]] = [set() for _ in range(len(self))]
        radius = math.ceil(NEIGHBOUR_DISTANCE_MAX)
        for segment, ends in enumerate(self.end_points):
            for x, y in ends:
                window = self.index[
                    max(round(y) - radius, 0) : round(y) + radius + 1,
                    max(round(x) - radius, 0) : round(x) + radius + 1,
                ]
                points = window[window >= 0]
                close = np.hypot(*(self.points[points] - [x, y]).T) <= NEIGHBOUR_DISTANCE_MAX
                for other in np.unique(
                    np.searchsorted(self.starts, points[close], side='right') - 1
                ).tolist():
                    if other != segment:
                        near[segment].add(other)
                        near[other].add(segment)
        return [sorted(others) for others in near]


def trace_segments(edges: Edges, settings: EdgeSettings) -> Segments:
    """Link edges to segments and remove weak and short ones (paper 3.3b, 3.4).

    Args:
        edges: edges of the image.
        settings: edge detection settings that were taught for the place.
    """
    successors = link_points(edges.points, edges.gradients, edges.index)
    magnitudes = np.sqrt(np.einsum('ij,ij->i', edges.gradients, edges.gradients))
    count_min = max(2, round(settings.length_min))
    order, starts, closed = extract_chains(successors, magnitudes, settings.threshold, count_min)
    points = edges.points.take(order, axis=0)
    vertex_indices, vertex_starts = polyline_vertices(points, starts, settings.bend_tolerance)
    index = index_points(points, edges.index.shape)
    return Segments(
        *(points, edges.gradients.take(order, axis=0), starts, closed, vertex_indices, vertex_starts),
        index=index,
    )
