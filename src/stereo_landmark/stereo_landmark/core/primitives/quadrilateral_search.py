"""Rings of four sides that turn the same way: quadrilaterals, some of their corners perhaps hidden."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner_links import CornerLinks

# One side of four may have the bright side elsewhere: a panel before a wall that is bright on one side only.
_ODD_SIDES_MAX = 1


def order_links(
    links: CornerLinks, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return where each end's links begin, the ends they lead to, and the vertices; only turns to the right.

    Args:
        links: pairs of ends.
        count: number of sides.

    Returns:
        starts, shape (2 count + 1,), by 2 side + end; ends in the same numbering, shape (n,); vertices (n, 2).
    """
    nodes = 2 * links.sides + links.ends
    right = links.turns > 0.0
    # Walked the other way round, a turn to the left is one to the right.
    first = np.where(right, nodes[:, 0], nodes[:, 1])
    second = np.where(right, nodes[:, 1], nodes[:, 0])
    order = np.argsort(first, kind='stable')
    starts = np.searchsorted(first[order], np.arange(2 * count + 1))
    return starts.astype(np.int64), second[order], links.vertices[order]


@njit(cache=True, error_model='numpy')
def find_rings(
    starts: NDArray[np.int64],
    second: NDArray[np.int64],
    vertices: NDArray[np.float64],
    ends: NDArray[np.float64],
    covered: NDArray[np.float64],
    side_seen_min: float,
    outline_seen_min: float,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Return rings of four sides, clockwise in the image.

    Args:
        starts: shape (2 n + 1,), from :func:`order_links`, and the next two also.
        second: shape (m,), ends that links lead to.
        vertices: shape (m, 2) [px].
        ends: shape (n, 2, 2), of the sides [px].
        covered: shape (n,), length along which a side is seen [px].
        side_seen_min: part of each side that must be seen.
        outline_seen_min: part of the whole outline that must be seen.

    Returns:
        the ends by which the sides are entered, shape (k, 4), in the numbering 2 side + end; the corners
        before each side, shape (k, 4, 2) [px]; the part of the outline that is seen, shape (k,).
    """
    room = 8 * len(covered) + 16
    rings, corners, seen = np.empty((room, 4), np.int64), np.empty((room, 4, 2)), np.empty(room)
    count = 0
    for node in range(2 * len(covered)):
        for a in range(starts[node ^ 1], starts[(node ^ 1) + 1]):
            if second[a] // 2 <= node // 2:
                continue
            for b in range(starts[second[a] ^ 1], starts[(second[a] ^ 1) + 1]):
                if second[b] // 2 <= node // 2 or not _is_seen(
                    second[a], vertices[a], vertices[b], covered, ends, side_seen_min
                ):
                    continue
                for c in range(starts[second[b] ^ 1], starts[(second[b] ^ 1) + 1]):
                    last = second[c]
                    if last // 2 <= node // 2 or last // 2 == second[a] // 2:
                        continue
                    if not _is_seen(second[b], vertices[b], vertices[c], covered, ends, side_seen_min):
                        continue
                    d = _closing(starts, second, last ^ 1, node)
                    if d < 0 or count == room:
                        continue
                    ring = rings[count]
                    ring[0], ring[1], ring[2], ring[3] = node, second[a], second[b], last
                    corners[count, 0], corners[count, 1] = vertices[d], vertices[a]
                    corners[count, 2], corners[count, 3] = vertices[b], vertices[c]
                    seen[count] = _seen_part(ring, corners[count], covered, ends, side_seen_min)
                    if seen[count] >= outline_seen_min:
                        count += 1
    return rings[:count].copy(), corners[:count].copy(), seen[:count].copy()


@njit(cache=True, error_model='numpy')
def _closing(starts: NDArray[np.int64], second: NDArray[np.int64], node: int, wanted: int) -> int:
    for d in range(starts[node], starts[node + 1]):
        if second[d] == wanted:
            return d
    return -1


@njit(cache=True, error_model='numpy')
def _is_seen(
    node: int,
    begin: NDArray[np.float64],
    end: NDArray[np.float64],
    covered: NDArray[np.float64],
    ends: NDArray[np.float64],
    part_min: float,
) -> bool:
    """Whether a side runs from one corner to the other and enough of it is seen."""
    side, entered = node // 2, node % 2
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    ex = ends[side, 1 - entered, 0] - ends[side, entered, 0]
    ey = ends[side, 1 - entered, 1] - ends[side, entered, 1]
    return dx * ex + dy * ey > 0.0 and covered[side] >= part_min * np.sqrt(dx * dx + dy * dy)


@njit(cache=True, error_model='numpy')
def _seen_part(
    ring: NDArray[np.int64],
    corners: NDArray[np.float64],
    covered: NDArray[np.float64],
    ends: NDArray[np.float64],
    part_min: float,
) -> float:
    """Return the part of the outline that is seen; 0 where a side is not, or too many have odd polarity."""
    forward = 0
    outline, found = 0.0, 0.0
    for k in range(4):
        begin, end = corners[k], corners[(k + 1) % 4]
        if not _is_seen(ring[k], begin, end, covered, ends, part_min):
            return 0.0
        length = np.sqrt((end[0] - begin[0]) ** 2 + (end[1] - begin[1]) ** 2)
        outline += length
        found += min(length, covered[ring[k] // 2])
        forward += 1 - ring[k] % 2
    return found / outline if min(forward, 4 - forward) <= _ODD_SIDES_MAX else 0.0


@njit(cache=True, error_model='numpy')
def distinct_outlines(
    outlines: NDArray[np.float64], order: NDArray[np.int64], distance: float
) -> NDArray[np.int64]:
    """Return which outlines to keep, in the given order: of nearly equal ones the first.

    Args:
        outlines: shape (n, 8), coordinates of the corners [px].
        order: shape (n,), the best first.
        distance: outlines are equal when no coordinate differs by more [px].
    """
    kept = np.empty(len(order), np.int64)
    count = 0
    for k in order:
        new = True
        for other in kept[:count]:
            if _are_near(outlines[other], outlines[k], distance):
                new = False
                break
        if new:
            kept[count] = k
            count += 1
    return kept[:count].copy()


@njit(cache=True, error_model='numpy')
def _are_near(one: NDArray[np.float64], other: NDArray[np.float64], distance: float) -> bool:
    for c in range(len(one)):
        if abs(one[c] - other[c]) >= distance:
            return False
    return True
