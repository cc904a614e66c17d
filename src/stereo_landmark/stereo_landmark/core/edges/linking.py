"""Kernels that link edge points to chains and approximate these by polylines (paper 3.3b, 3.4)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Masks

# Largest distance between linked edge points [px], and weight of the squared deviation across the edge.
_LINK_DISTANCE_MAX = 2
_ACROSS_WEIGHT = 4.0


@njit(cache=True, error_model='numpy')
def link_points(points: Floats, gradients: Floats, index: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the successor of each edge point, shape (n,), -1 at an end; the bright side is on the right.

    Two points are linked if each is the best match of the other (mutual nearest neighbours): the nearest one
    along the edge with a similar gradient direction. The result does not depend on the order of the points.

    Args:
        points: edge points, row by row, shape (n, 2) [px].
        gradients: image gradients, shape (n, 2) [grey levels / px].
        index: index of the edge point in each pixel or -1, shape (h, w).
    """
    count = len(points)
    normals = np.empty((count, 2))
    for i in range(count):
        norm = np.sqrt(gradients[i, 0] ** 2 + gradients[i, 1] ** 2)
        normals[i, 0], normals[i, 1] = gradients[i, 0] / norm, gradients[i, 1] / norm
    successors = np.full(count, -1, np.int32)
    predecessors = np.full(count, -1, np.int32)
    _link_adjacent(points, normals, index, successors, predecessors)
    for i in range(count):
        # Pixels farther away are searched only if no adjacent pixel matches.
        for radius in range(2, _LINK_DISTANCE_MAX + 1):
            if successors[i] < 0 or predecessors[i] < 0:
                _link_at_distance(points, normals, index, i, radius, successors, predecessors)
    for i in range(count):
        if successors[i] >= 0 and predecessors[successors[i]] != i:
            successors[i] = -1
    return successors


@njit(cache=True, error_model='numpy')
def _link_adjacent(
    points: Floats,
    normals: Floats,
    index: NDArray[np.int32],
    successors: NDArray[np.int32],
    predecessors: NDArray[np.int32],
) -> None:
    """Write the best links among adjacent pixels; each pair of pixels is evaluated once, for both directions."""
    height, width = index.shape
    successor_costs, predecessor_costs = np.full(len(points), np.inf), np.full(len(points), np.inf)
    for i in range(len(points)):
        x, y = int(np.rint(points[i, 0])), int(np.rint(points[i, 1]))
        for step in range(4):
            # The neighbour on the right and the three neighbours below.
            u, v = (x + 1, y) if step == 0 else (x + step - 2, y + 1)
            if u < 0 or u >= width or v >= height or index[v, u] < 0:
                continue
            j = index[v, u]
            along, cost = _link_cost(points, normals, i, j)
            before, after = (i, j) if along > 0.0 else (j, i)
            if along != 0.0 and cost < successor_costs[before]:
                successor_costs[before], successors[before] = cost, after
            if along != 0.0 and cost < predecessor_costs[after]:
                predecessor_costs[after], predecessors[after] = cost, before


@njit(cache=True, error_model='numpy')
def _link_at_distance(
    points: Floats,
    normals: Floats,
    index: NDArray[np.int32],
    i: int,
    radius: int,
    successors: NDArray[np.int32],
    predecessors: NDArray[np.int32],
) -> None:
    """Write the missing links of point i, the best among the pixels at one Chebyshev distance."""
    x, y = int(np.rint(points[i, 0])), int(np.rint(points[i, 1]))
    height, width = index.shape
    needs_successor, needs_predecessor = successors[i] < 0, predecessors[i] < 0
    best_successor_cost = best_predecessor_cost = np.inf
    for v in range(max(y - radius, 0), min(y + radius + 1, height)):
        step = 1 if abs(v - y) == radius else 2 * radius
        for u in range(x - radius, x + radius + 1, step):
            if u < 0 or u >= width or index[v, u] < 0:
                continue
            j = index[v, u]
            along, cost = _link_cost(points, normals, i, j)
            if needs_successor and along > 0.0 and cost < best_successor_cost:
                best_successor_cost, successors[i] = cost, j
            elif needs_predecessor and along < 0.0 and cost < best_predecessor_cost:
                best_predecessor_cost, predecessors[i] = cost, j


@njit(cache=True, error_model='numpy')
def _link_cost(points: Floats, normals: Floats, i: int, j: int) -> tuple[float, float]:
    """Return the signed position of j along the edge (0: not the same edge) and the cost of the link."""
    # The mean normal of both points makes the cost symmetric.
    nx, ny = normals[i, 0] + normals[j, 0], normals[i, 1] + normals[j, 1]
    squared = nx * nx + ny * ny
    if squared <= 2.0:
        return 0.0, np.inf
    dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    along, across = ny * dx - nx * dy, nx * dx + ny * dy
    return along, (along * along + _ACROSS_WEIGHT * across * across) / squared


@njit(cache=True, error_model='numpy')
def extract_chains(
    successors: NDArray[np.int32], magnitudes: Floats, threshold: float, count_min: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], Masks]:
    """Return the chains that reach the upper threshold and are long enough (the paper's noise removal).

    Args:
        successors: successor of each edge point or -1, shape (n,).
        magnitudes: gradient magnitudes, shape (n,) [grey levels / px].
        threshold: magnitude that a chain must reach at one point [grey levels / px].
        count_min: minimum number of points.

    Returns:
        edge point indices of all chains, concatenated; start of each chain, shape (m + 1,); closed flags,
        shape (m,). Open chains come first, each group in the order of the first edge point.
    """
    n = len(successors)
    has_predecessor = np.zeros(n, np.bool_)
    for i in range(n):
        if successors[i] >= 0:
            has_predecessor[successors[i]] = True
    visited = np.zeros(n, np.bool_)
    order, starts, closed = np.empty(n, np.int32), np.zeros(n + 1, np.int32), np.zeros(n, np.bool_)
    filled, chains = 0, 0
    for is_closed in (False, True):
        for first in range(n):
            if visited[first] or (has_predecessor[first] != is_closed):
                continue
            end, strongest, i = filled, 0.0, first
            while i >= 0 and not visited[i]:
                visited[i] = True
                order[end] = i
                strongest = max(strongest, magnitudes[i])
                end += 1
                i = successors[i]
            if strongest >= threshold and end - filled >= count_min:
                closed[chains] = is_closed
                chains += 1
                starts[chains] = end
                filled = end
    return order[:filled].copy(), starts[: chains + 1].copy(), closed[:chains].copy()


@njit(cache=True, error_model='numpy')
def index_points(points: Floats, shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return an image with the index of the point in each pixel, -1 where there is none.

    Args:
        points: edge points, shape (n, 2) [px].
        shape: image height and width [px].
    """
    index = np.full(shape, -1, np.int32)
    for i in range(len(points)):
        index[int(np.rint(points[i, 1])), int(np.rint(points[i, 0]))] = i
    return index


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
