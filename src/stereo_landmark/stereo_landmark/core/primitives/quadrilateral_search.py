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
    """Sides and the m right turns between them; an end of a side is numbered 2 side + end.

    Attributes:
        starts: shape (2 n + 1,), where the links that leave by each end begin.
        first: shape (m,), those ends.
        second: shape (m,), the ends by which the next sides are entered.
        vertices: shape (m, 2), where that happens [px].
        left_at: shape (m,), how far along the side that is left, from where it was entered [px].
        entered_at: shape (m,), how far along the side that is entered, from its end; negative before it [px].
        coming: shape (m,), the links by the ends that they enter.
        coming_starts: shape (2 n + 1,), where those of each end begin.
        covered: shape (n,), length along which a side is seen [px].
        side_seen_min: part of each side that must be seen.
        outline_seen_min: part of the whole outline that must be seen.
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
    first, second, vertices = first[order], second[order], links.vertices[order]
    coming = np.argsort(second, kind='stable')
    numbers = np.arange(2 * len(covered) + 1)
    starts, coming_starts = (
        np.searchsorted(sorted_ends, numbers).astype(np.int64) for sorted_ends in (first, second[coming])
    )
    # What is left was entered by its other end.
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
    """Return how far vertices are along sides from the ends by which these are entered, shape (m,) [px]."""
    along = np.empty(len(entered))
    for m in range(len(entered)):
        begin, end = ends[entered[m] >> 1, entered[m] & 1], ends[entered[m] >> 1, 1 - (entered[m] & 1)]
        dx, dy = end[0] - begin[0], end[1] - begin[1]
        product = dx * (vertices[m, 0] - begin[0]) + dy * (vertices[m, 1] - begin[1])
        along[m] = product / np.sqrt(dx * dx + dy * dy)
    return along


@njit(cache=True, error_model='numpy')
def find_rings(graph: CornerGraph) -> Rings:
    """Return the rings of four sides that are seen well enough, each once."""
    starts, second = graph.starts, graph.second
    room = 8 * len(graph.covered) + 16
    rings = Rings(np.empty((room, 4), np.int64), np.empty((room, 4, 2)), np.empty(room))
    closing = np.full(2 * len(graph.covered), -1)
    count = np.int64(0)  # typed: numba compiles _close_rings once more for a bare number
    for node in range(2 * len(graph.covered)):
        # A ring is found from its first side only.
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
    """Write the link to a node from each side by the end where that is entered; return whether there is any."""
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
    """Add the rings that begin with a side and two links; return how many there are now."""
    second = graph.second
    for c in range(graph.starts[second[b] ^ 1], graph.starts[(second[b] ^ 1) + 1]):
        last = second[c]
        d = closing[last]
        if d < 0 or last >> 1 <= node >> 1 or last >> 1 == second[a] >> 1 or count == len(rings.seen):
            continue
        # Those entered by their first end are walked with the bright side to the right.
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
    """Return how long a side is from one link to the next [px]; 0 where too little of that is seen."""
    length = graph.left_at[after] - graph.entered_at[before]
    return (
        max(length, 0.0) if graph.covered[graph.second[before] >> 1] >= graph.side_seen_min * length else 0.0
    )


@njit(cache=True, error_model='numpy')
def _seen_part(graph: CornerGraph, a: int, b: int, c: int, d: int) -> float:
    """Return the part of the outline of four links that is seen; 0 where a side is not."""
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
