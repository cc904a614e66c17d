"""Rings of four sides that turn the same way: quadrilaterals, some of their corners perhaps hidden."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner_links import CornerLinks

# One side of four may have the bright side elsewhere: a panel before a wall that is bright on one side only.
_ODD_SIDES_MAX = 1


class CornerGraph(NamedTuple):
    """Sides and the right turns between them; an end of a side is numbered 2 side + end.

    Attributes:
        starts: shape (2 n + 1,), where the links that leave by each end begin.
        second: shape (m,), the ends by which the next sides are entered.
        vertices: shape (m, 2), where that happens [px].
        ends: shape (n, 2, 2), of the sides [px].
        covered: shape (n,), length along which a side is seen [px].
        side_seen_min: part of each side that must be seen.
        outline_seen_min: part of the whole outline that must be seen.
    """

    starts: NDArray[np.int64]
    second: NDArray[np.int64]
    vertices: NDArray[np.float64]
    ends: NDArray[np.float64]
    covered: NDArray[np.float64]
    side_seen_min: float
    outline_seen_min: float


class Rings(NamedTuple):
    """Rings of four sides, clockwise in the image.

    Attributes:
        entered: shape (k, 4), the ends by which the sides are entered.
        corners: shape (k, 4, 2), before each side [px].
        seen: shape (k,), part of the outline that is seen.
    """

    entered: NDArray[np.int64]
    corners: NDArray[np.float64]
    seen: NDArray[np.float64]


def corner_graph(
    links: CornerLinks,
    ends: NDArray[np.float64],
    covered: NDArray[np.float64],
    side_seen_min: float,
    outline_seen_min: float,
) -> CornerGraph:
    """Return the graph of the right turns among sides.

    Args:
        links: pairs of ends.
        ends: shape (n, 2, 2), of the sides [px].
        covered: shape (n,), length along which a side is seen [px].
        side_seen_min: part of each side that must be seen.
        outline_seen_min: part of the whole outline that must be seen.
    """
    nodes = 2 * links.sides + links.ends
    right = links.turns > 0.0
    # Walked the other way round, a turn to the left is one to the right.
    first = np.where(right, nodes[:, 0], nodes[:, 1])
    second = np.where(right, nodes[:, 1], nodes[:, 0])
    order = np.argsort(first, kind='stable')
    starts = np.searchsorted(first[order], np.arange(2 * len(covered) + 1)).astype(np.int64)
    vertices = links.vertices[order]
    return CornerGraph(starts, second[order], vertices, ends, covered, side_seen_min, outline_seen_min)


@njit(cache=True, error_model='numpy')
def find_rings(graph: CornerGraph) -> Rings:
    """Return the rings of four sides that are seen well enough, each once."""
    starts, second = graph.starts, graph.second
    room = 8 * len(graph.covered) + 16
    rings = Rings(np.empty((room, 4), np.int64), np.empty((room, 4, 2)), np.empty(room))
    count = np.int64(0)  # typed: numba compiles _close_rings once more for a bare number
    for node in range(2 * len(graph.covered)):
        for a in range(starts[node ^ 1], starts[(node ^ 1) + 1]):
            # A ring is found from its first side only.
            if second[a] // 2 <= node // 2:
                continue
            for b in range(starts[second[a] ^ 1], starts[(second[a] ^ 1) + 1]):
                if second[b] // 2 > node // 2 and _is_seen(
                    graph, second[a], graph.vertices[a], graph.vertices[b]
                ):
                    count = _close_rings(graph, node, a, b, rings, count)
    return Rings(rings.entered[:count].copy(), rings.corners[:count].copy(), rings.seen[:count].copy())


@njit(cache=True, error_model='numpy')
def _close_rings(graph: CornerGraph, node: int, a: int, b: int, rings: Rings, count: int) -> int:
    """Add the rings that begin with a side and two links; return how many there are now."""
    second, vertices = graph.second, graph.vertices
    for c in range(graph.starts[second[b] ^ 1], graph.starts[(second[b] ^ 1) + 1]):
        last = second[c]
        if last // 2 <= node // 2 or last // 2 == second[a] // 2:
            continue
        d = _link_between(graph, last ^ 1, node)
        if d < 0 or count == len(rings.seen):
            continue
        entered, corners = rings.entered[count], rings.corners[count]
        entered[0], entered[1], entered[2], entered[3] = node, second[a], second[b], last
        corners[0], corners[1], corners[2], corners[3] = vertices[d], vertices[a], vertices[b], vertices[c]
        rings.seen[count] = _seen_part(graph, entered, corners)
        if rings.seen[count] >= graph.outline_seen_min:
            count += 1
    return count


@njit(cache=True, error_model='numpy')
def _link_between(graph: CornerGraph, node: int, wanted: int) -> int:
    for d in range(graph.starts[node], graph.starts[node + 1]):
        if graph.second[d] == wanted:
            return d
    return -1


@njit(cache=True, error_model='numpy')
def _is_seen(graph: CornerGraph, node: int, begin: NDArray[np.float64], end: NDArray[np.float64]) -> bool:
    """Whether a side runs from one corner to the other and enough of it is seen."""
    side, entered = node // 2, node % 2
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    ex = graph.ends[side, 1 - entered, 0] - graph.ends[side, entered, 0]
    ey = graph.ends[side, 1 - entered, 1] - graph.ends[side, entered, 1]
    return dx * ex + dy * ey > 0.0 and graph.covered[side] >= graph.side_seen_min * np.sqrt(dx * dx + dy * dy)


@njit(cache=True, error_model='numpy')
def _seen_part(graph: CornerGraph, entered: NDArray[np.int64], corners: NDArray[np.float64]) -> float:
    """Return the part of the outline that is seen; 0 where a side is not, or too many have odd polarity."""
    forward = 0
    outline, found = 0.0, 0.0
    for k in range(4):
        begin, end = corners[k], corners[(k + 1) % 4]
        if not _is_seen(graph, entered[k], begin, end):
            return 0.0
        length = np.sqrt((end[0] - begin[0]) ** 2 + (end[1] - begin[1]) ** 2)
        outline += length
        found += min(length, graph.covered[entered[k] // 2])
        forward += 1 - entered[k] % 2
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
    if not len(order):
        return kept
    # Equal ones begin in the same column of cells or in the next one; each column is a list from the last one back.
    left = np.min(outlines[:, 0])
    columns = ((outlines[:, 0] - left) / distance).astype(np.int64) + 1
    last, before = np.full(np.max(columns) + 2, -1), np.full(len(order), -1)
    count = 0
    for k in order:
        if _is_new(outlines, k, kept, columns[k], last, before, distance):
            kept[count] = k
            before[count], last[columns[k]] = last[columns[k]], count
            count += 1
    return kept[:count].copy()


@njit(cache=True, error_model='numpy')
def _is_new(
    outlines: NDArray[np.float64],
    k: int,
    kept: NDArray[np.int64],
    column: int,
    last: NDArray[np.int64],
    before: NDArray[np.int64],
    distance: float,
) -> bool:
    for near in range(column - 1, column + 2):
        number = last[near]
        while number >= 0:
            if _are_near(outlines[kept[number]], outlines[k], distance):
                return False
            number = before[number]
    return True


@njit(cache=True, error_model='numpy')
def _are_near(one: NDArray[np.float64], other: NDArray[np.float64], distance: float) -> bool:
    largest = 0.0
    for c in range(len(one)):
        largest = max(largest, abs(one[c] - other[c]))
    return largest < distance
