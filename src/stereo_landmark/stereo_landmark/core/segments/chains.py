"""Edge linking: each edge point gets at most one successor and one predecessor; chains follow from the links."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Largest distance between linked edge points [px], and weight of the squared deviation across the edge.
_REACH = 2
_ACROSS = 4.0


@njit(cache=True, error_model='numpy')
def link_points(
    points: NDArray[np.float64], gradients: NDArray[np.float64], index: NDArray[np.int32]
) -> NDArray[np.int32]:
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
    ahead = np.full(count, -1, np.int32)
    behind = np.full(count, -1, np.int32)
    _link_touching(points, normals, index, ahead, behind)
    for i in range(count):
        # Pixels farther away are searched only if no adjacent pixel matches.
        for ring in range(2, _REACH + 1):
            if ahead[i] < 0 or behind[i] < 0:
                _choose_links(points, normals, index, i, ring, ahead, behind)
    for i in range(count):
        if ahead[i] >= 0 and behind[ahead[i]] != i:
            ahead[i] = -1
    return ahead


@njit(cache=True, error_model='numpy')
def _link_touching(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    index: NDArray[np.int32],
    ahead: NDArray[np.int32],
    behind: NDArray[np.int32],
) -> None:
    """Write the best links among adjacent pixels; each pair of pixels is evaluated once, for both directions."""
    height, width = index.shape
    least_ahead, least_behind = np.full(len(points), np.inf), np.full(len(points), np.inf)
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
            if along != 0.0 and cost < least_ahead[before]:
                least_ahead[before], ahead[before] = cost, after
            if along != 0.0 and cost < least_behind[after]:
                least_behind[after], behind[after] = cost, before


@njit(cache=True, error_model='numpy')
def _choose_links(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    index: NDArray[np.int32],
    i: int,
    ring: int,
    ahead: NDArray[np.int32],
    behind: NDArray[np.int32],
) -> None:
    """Write the missing links of point i, the best among the pixels at one Chebyshev distance."""
    x, y = int(np.rint(points[i, 0])), int(np.rint(points[i, 1]))
    height, width = index.shape
    wants_ahead, wants_behind = ahead[i] < 0, behind[i] < 0
    best_ahead = best_behind = np.inf
    for v in range(max(y - ring, 0), min(y + ring + 1, height)):
        step = 1 if abs(v - y) == ring else 2 * ring
        for u in range(x - ring, x + ring + 1, step):
            if u < 0 or u >= width or index[v, u] < 0:
                continue
            j = index[v, u]
            along, cost = _link_cost(points, normals, i, j)
            if wants_ahead and along > 0.0 and cost < best_ahead:
                best_ahead, ahead[i] = cost, j
            elif wants_behind and along < 0.0 and cost < best_behind:
                best_behind, behind[i] = cost, j


@njit(cache=True, error_model='numpy')
def _link_cost(
    points: NDArray[np.float64], normals: NDArray[np.float64], i: int, j: int
) -> tuple[float, float]:
    """Return the signed position of j along the edge (0: not the same edge) and the cost of the link."""
    # The mean normal of both points makes the cost symmetric.
    nx, ny = normals[i, 0] + normals[j, 0], normals[i, 1] + normals[j, 1]
    squared = nx * nx + ny * ny
    if squared <= 2.0:
        return 0.0, np.inf
    dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    along, across = ny * dx - nx * dy, nx * dx + ny * dy
    return along, (along * along + _ACROSS * across * across) / squared


@njit(cache=True, error_model='numpy')
def read_chains(
    ahead: NDArray[np.int32], strengths: NDArray[np.float64], threshold: float, count_min: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.bool_]]:
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
    n = len(ahead)
    has_forerunner = np.zeros(n, np.bool_)
    for i in range(n):
        if ahead[i] >= 0:
            has_forerunner[ahead[i]] = True
    taken = np.zeros(n, np.bool_)
    order, starts, closed = np.empty(n, np.int32), np.zeros(n + 1, np.int32), np.zeros(n, np.bool_)
    filled, chains = 0, 0
    for loops in (False, True):
        for first in range(n):
            if taken[first] or (has_forerunner[first] != loops):
                continue
            end, strongest, i = filled, 0.0, first
            while i >= 0 and not taken[i]:
                taken[i] = True
                order[end] = i
                strongest = max(strongest, strengths[i])
                end += 1
                i = ahead[i]
            if strongest >= threshold and end - filled >= count_min:
                closed[chains] = loops
                chains += 1
                starts[chains] = end
                filled = end
    return order[:filled].copy(), starts[: chains + 1].copy(), closed[:chains].copy()


@njit(cache=True, error_model='numpy')
def index_points(points: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.int32]:
    """Return an image with the index of the point in each pixel, -1 where there is none.

    Args:
        points: edge points, shape (n, 2) [px].
        shape: image height and width [px].
    """
    index = np.full(shape, -1, np.int32)
    for i in range(len(points)):
        index[int(np.rint(points[i, 1])), int(np.rint(points[i, 0]))] = i
    return index
