"""Segments: linked edge points with polylines and the other attributes that the paper lists (3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Masks
from stereo_landmark.core.edges.edges import Edges
from stereo_landmark.core.edges.segments import extract_chains, index_points, link_points
from stereo_landmark.core.settings import EdgeSettings


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

    points: Floats
    gradients: Floats
    starts: NDArray[np.int32]
    closed: Masks
    vertex_indices: NDArray[np.int32]
    vertex_starts: NDArray[np.int32]
    index: NDArray[np.int32]

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.closed)


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


@njit(cache=True, error_model='numpy')
def polyline_vertices(
    points: Floats, starts: NDArray[np.int32], tolerance: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Split each segment at the point farthest from its chord until all distances are within the tolerance.

    An early split may fall on a straight run. Such vertices become redundant after later splits and are removed.

    Args:
        points: points of all segments, concatenated, shape (n, 2) [px].
        starts: start of each segment in ``points``, shape (m + 1,).
        tolerance: largest distance between segment and polyline [px].

    Returns:
        indices of the vertices in ``points``, segment ends included; start of each segment among them,
        shape (m + 1,).
    """
    n = len(points)
    is_vertex = np.zeros(n, np.bool_)
    stack = np.empty((n + 2, 2), np.int32)
    for s in range(len(starts) - 1):
        first, last = starts[s], starts[s + 1] - 1
        is_vertex[first] = is_vertex[last] = True
        stack[0, 0], stack[0, 1] = first, last
        depth = 1
        while depth > 0:
            depth -= 1
            a, b = stack[depth]
            farthest, distance = _farthest_point(points, a, b)
            if distance > tolerance:
                is_vertex[farthest] = True
                stack[depth, 0], stack[depth, 1] = a, farthest
                stack[depth + 1, 0], stack[depth + 1, 1] = farthest, b
                depth += 2
        _remove_redundant(points, first, last, tolerance, is_vertex)
    vertex_indices = np.flatnonzero(is_vertex).astype(np.int32)
    return vertex_indices, np.searchsorted(vertex_indices, starts).astype(np.int32)


@njit(cache=True, error_model='numpy')
def _remove_redundant(points: Floats, first: int, last: int, tolerance: float, is_vertex: Masks) -> None:
    """Remove the vertices of a segment that its polyline does not need to stay within the tolerance."""
    previous, candidate = first, -1
    for i in range(first + 1, last + 1):
        if not is_vertex[i]:
            continue
        if candidate >= 0:
            if _farthest_point(points, previous, i)[1] <= tolerance:
                is_vertex[candidate] = False
            else:
                previous = candidate
        candidate = i


@njit(cache=True, error_model='numpy')
def _farthest_point(points: Floats, a: int, b: int) -> tuple[int, float]:
    """Return the point farthest from the chord from a to b, and its distance [px]."""
    dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    chord = np.hypot(dx, dy)
    farthest, most = a, 0.0
    for i in range(a + 1, b):
        ex, ey = points[i, 0] - points[a, 0], points[i, 1] - points[a, 1]
        # The chord of a closed segment has length zero.
        distance = abs(dx * ey - dy * ex) / chord if chord > 1e-9 else np.hypot(ex, ey)
        if distance > most:
            farthest, most = i, distance
    return farthest, most
