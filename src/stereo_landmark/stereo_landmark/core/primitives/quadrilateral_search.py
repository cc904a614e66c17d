"""Quadrilateral detection: cycles of four right turns in the graph of line segments; corners may be occluded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner_links import CornerLinks

# One of four sides may have reversed polarity, e.g. a panel in front of a background that is dark on one side.
_ODD_SIDES_MAX = 1


class CornerGraph(NamedTuple):
    """Graph of n line segments with m right turns as links; the node number of an end point is 2 segment + end.

    Attributes:
        starts: start of the outgoing links of each node, shape (2 n + 1,).
        from_ends: nodes where the links leave, shape (m,).
        to_ends: nodes where the links enter the next segment, shape (m,).
        vertices: intersections of both segments, shape (m, 2) [px].
        exit_positions: vertex positions along the segments that are left, from their entry ends, shape (m,) [px].
        entry_positions: vertex positions along the entered segments, negative in front of them, shape (m,) [px].
        incoming: links sorted by the nodes that they enter, shape (m,).
        incoming_starts: start of the incoming links of each node, shape (2 n + 1,).
        support: length of the edges that support each segment, shape (n,) [px].
        side_seen_min: smallest visible fraction of each side.
        outline_seen_min: smallest visible fraction of the whole outline.
    """

    starts: NDArray[np.int64]
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    vertices: NDArray[np.float64]
    left_at: NDArray[np.float64]
    entered_at: NDArray[np.float64]
    coming: NDArray[np.int64]
    coming_starts: NDArray[np.int64]
    covered: NDArray[np.float64]
    side_seen_min: float
    outline_seen_min: float


class Rings(NamedTuple):
    """Closed cycles of four line segments, clockwise in the image.

    Attributes:
        entry_ends: nodes where the segments are entered, shape (k, 4).
        corners: corner in front of each segment, shape (k, 4, 2) [px].
        seen: visible fraction of the outline, shape (k,).
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
    """Return the graph of the right turns between line segments.

    Args:
        links: pairs of end points.
        ends: end points of the line segments, shape (n, 2, 2) [px].
        support: length of the edges that support each segment, shape (n,) [px].
        side_seen_min: smallest visible fraction of each side.
        outline_seen_min: smallest visible fraction of the whole outline.
    """
    nodes = 2 * links.sides + links.ends
    right = links.turns > 0.0
    # In the opposite direction a left turn is a right turn.
    first = np.where(right, nodes[:, 0], nodes[:, 1])
    second = np.where(right, nodes[:, 1], nodes[:, 0])
    order = np.argsort(first, kind='stable')
    first, second, vertices = first[order], second[order], links.vertices[order]
    coming = np.argsort(second, kind='stable')
    numbers = np.arange(2 * len(covered) + 1)
    starts, coming_starts = (
        np.searchsorted(sorted_ends, numbers).astype(np.int64) for sorted_ends in (first, second[coming])
    )
    # The segment that is left was entered at its other end.
    left_at, entered_at = _along(ends, first ^ 1, vertices), _along(ends, second, vertices)
    return CornerGraph(
        *(starts, first, second, vertices, left_at, entered_at, coming, coming_starts, covered),
        side_seen_min=side_seen_min,
        outline_seen_min=outline_seen_min,
    )


@njit(cache=True, error_model='numpy')
def _along(
    ends: NDArray[np.float64], entered: NDArray[np.int64], vertices: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the positions of vertices along segments from the ends where these are entered, shape (m,) [px]."""
    along = np.empty(len(entered))
    for m in range(len(entered)):
        begin, end = ends[entered[m] >> 1, entered[m] & 1], ends[entered[m] >> 1, 1 - (entered[m] & 1)]
        dx, dy = end[0] - begin[0], end[1] - begin[1]
        product = dx * (vertices[m, 0] - begin[0]) + dy * (vertices[m, 1] - begin[1])
        along[m] = product / np.sqrt(dx * dx + dy * dy)
    return along


@njit(cache=True, error_model='numpy')
def find_rings(graph: CornerGraph) -> Rings:
    """Return the cycles of four line segments with sufficient visible fractions, each once."""
    starts, second = graph.starts, graph.second
    room = 8 * len(graph.covered) + 16
    rings = Rings(np.empty((room, 4), np.int64), np.empty((room, 4, 2)), np.empty(room))
    closing = np.full(2 * len(graph.covered), -1)
    count = np.int64(0)  # typed: numba compiles _close_rings once more for a bare number
    for node in range(2 * len(graph.covered)):
        # Each cycle starts at its segment with the lowest index.
        if not _mark_closing(graph, node, closing):
            continue
        for a in range(starts[node ^ 1], starts[(node ^ 1) + 1]):
            if second[a] >> 1 <= node >> 1:
                continue
            for b in range(starts[second[a] ^ 1], starts[(second[a] ^ 1) + 1]):
                if second[b] >> 1 > node >> 1 and _length(graph, a, b) > 0.0:
                    count = _close_rings(graph, node, a, b, closing, rings, count)
        for c in range(graph.coming_starts[node], graph.coming_starts[node + 1]):
            closing[graph.first[graph.coming[c]] ^ 1] = -1
    return Rings(rings.entered[:count].copy(), rings.corners[:count].copy(), rings.seen[:count].copy())


@njit(cache=True, error_model='numpy')
def _mark_closing(graph: CornerGraph, node: int, closing: NDArray[np.int64]) -> bool:
    """Write the link to a node by the end where its segment was entered; return whether there is any."""
    is_any = False
    for c in range(graph.coming_starts[node], graph.coming_starts[node + 1]):
        link = graph.coming[c]
        closing[graph.first[link] ^ 1] = link
        is_any |= graph.first[link] >> 1 > node >> 1
    return is_any


@njit(cache=True, error_model='numpy')
def _close_rings(
    graph: CornerGraph, node: int, a: int, b: int, closing: NDArray[np.int64], rings: Rings, count: int
) -> int:
    """Add the cycles that start with a node and two links; return the new count."""
    second = graph.second
    for c in range(graph.starts[second[b] ^ 1], graph.starts[(second[b] ^ 1) + 1]):
        last = second[c]
        d = closing[last]
        if d < 0 or last >> 1 <= node >> 1 or last >> 1 == second[a] >> 1 or count == len(rings.seen):
            continue
        # Segments entered at their first end have the bright side on the right.
        forward = 4 - (node & 1) - (second[a] & 1) - (second[b] & 1) - (last & 1)
        seen = _seen_part(graph, a, b, c, d)
        if min(forward, 4 - forward) > _ODD_SIDES_MAX or seen < graph.outline_seen_min:
            continue
        for k, link in enumerate((d, a, b, c)):
            rings.entered[count, k], rings.corners[count, k] = second[link], graph.vertices[link]
        rings.seen[count] = seen
        count += 1
    return count


@njit(cache=True, error_model='numpy')
def _length(graph: CornerGraph, before: int, after: int) -> float:
    """Return the length of a side between two links [px], 0 if too little of it is visible."""
    length = graph.left_at[after] - graph.entered_at[before]
    return (
        max(length, 0.0) if graph.covered[graph.second[before] >> 1] >= graph.side_seen_min * length else 0.0
    )


@njit(cache=True, error_model='numpy')
def _seen_part(graph: CornerGraph, a: int, b: int, c: int, d: int) -> float:
    """Return the visible fraction of the outline of four links, 0 if a side is not visible enough."""
    outline, found = 0.0, 0.0
    for before, after in ((d, a), (a, b), (b, c), (c, d)):
        length = _length(graph, before, after)
        if length <= 0.0:
            return 0.0
        outline += length
        found += min(length, graph.covered[graph.second[before] >> 1])
    return found / outline


@njit(cache=True, error_model='numpy')
def distinct_outlines(
    outlines: NDArray[np.float64], order: NDArray[np.int64], distance: float
) -> NDArray[np.int64]:
    """Return the indices of the outlines to keep, in the given order, the first of each group of duplicates.

    Args:
        outlines: coordinates of the corners, shape (n, 8) [px].
        order: indices of the outlines, best first, shape (n,).
        distance: largest coordinate difference of duplicates [px].
    """
    kept = np.empty(len(order), np.int64)
    if not len(order):
        return kept
    # Duplicates are in the same or an adjacent column of cells; each column is a linked list from the last entry.
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
