"""Line following: each edge point gets at most one follower and one forerunner; chains are read off."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Edge points of a line lie at most so many pixels apart; and across the line they hardly deviate.
_REACH = 2
_ACROSS = 4.0


@njit(cache=True, error_model='numpy')
def link_points(
    points: NDArray[np.float64], gradients: NDArray[np.float64], index: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Return the follower of each edge point, shape (n,), -1 at an end; the bright side lies to the right.

    A link is made where each of two points is the other's best: the nearest one along the line whose
    gradient points the same way. No order of the points plays a part in it.

    Args:
        points: shape (n, 2) [px], row by row.
        gradients: shape (n, 2) [grey levels / px].
        index: shape (h, w), edge point of each pixel or -1.
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
        # Farther pixels are asked only where the nearest ones have no answer.
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
    """Write the best links among pixels that touch; each two of them are looked at once, for both."""
    height, width = index.shape
    least_ahead, least_behind = np.full(len(points), np.inf), np.full(len(points), np.inf)
    for i in range(len(points)):
        x, y = int(np.rint(points[i, 0])), int(np.rint(points[i, 1]))
        for step in range(4):
            # The one to the right, and the three below.
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
    """Write the best links of point i among the pixels at one distance, where it has none yet."""
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
    """Return a number whose sign tells ahead from behind (0: not the same line), and the cost of the link."""
    # The mean normal of both, so that the step back costs what the step forth does.
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
    """Return the chains that reach the threshold and are long enough: the paper's noise removal.

    Args:
        ahead: shape (n,), follower of each edge point or -1.
        strengths: shape (n,) [grey levels / px].
        threshold: gradient that a chain must reach somewhere [grey levels / px].
        count_min: smallest number of points.

    Returns:
        the edge points of all chains one after another; where each begins, shape (m + 1,); whether each
        is closed, shape (m,). Open chains come first, each kind in the order of its first edge point.
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
    """Return the number of the point in each pixel of an image of some shape, -1 where there is none.

    Args:
        points: shape (n, 2) [px].
        shape: height and width.
    """
    index = np.full(shape, -1, np.int32)
    for i in range(len(points)):
        index[int(np.rint(points[i, 1])), int(np.rint(points[i, 0]))] = i
    return index
