"""Kernels of quadrilaterals: cycles of four right turns in the graph of line segments, and order of the corners."""

from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints

# One of four sides may have reversed polarity, e.g. a panel in front of a background that is dark on one side.
_REVERSED_SIDES_MAX = 1


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

    starts: Ints
    from_ends: Ints
    to_ends: Ints
    vertices: Floats
    exit_positions: Floats
    entry_positions: Floats
    incoming: Ints
    incoming_starts: Ints
    support: Floats
    side_seen_min: float
    outline_seen_min: float


class Cycles(NamedTuple):
    """Closed cycles of four line segments, clockwise in the image.

    Attributes:
        entry_ends: nodes where the segments are entered, shape (k, 4).
        corners: corner in front of each segment, shape (k, 4, 2) [px].
        seen: visible fraction of the outline, shape (k,).
    """

    entry_ends: Ints
    corners: Floats
    seen: Floats


@njit(cache=True, error_model='numpy')
def positions_along(ends: Floats, entry_ends: Ints, vertices: Floats) -> Floats:
    """Return the positions of vertices along segments from the ends where these are entered, shape (m,) [px]."""
    along = np.empty(len(entry_ends))
    for m in range(len(entry_ends)):
        line, side = entry_ends[m] >> 1, entry_ends[m] & 1
        begin, end = ends[line, side], ends[line, 1 - side]
        dx, dy = end[0] - begin[0], end[1] - begin[1]
        product = dx * (vertices[m, 0] - begin[0]) + dy * (vertices[m, 1] - begin[1])
        along[m] = product / np.sqrt(dx * dx + dy * dy)
    return along


@njit(cache=True, error_model='numpy')
def find_cycles(graph: CornerGraph) -> Cycles:
    """Return the cycles of four line segments with sufficient visible fractions, each once."""
    starts, to_ends = graph.starts, graph.to_ends
    capacity = 8 * len(graph.support) + 16
    cycles = Cycles(np.empty((capacity, 4), np.int64), np.empty((capacity, 4, 2)), np.empty(capacity))
    closing_links = np.full(2 * len(graph.support), -1)
    count = np.int64(0)  # typed: numba compiles _close_cycles once more for a bare number
    for node in range(2 * len(graph.support)):
        # Each cycle starts at its segment with the lowest index.
        if not _mark_closing_links(graph, node, closing_links):
            continue
        for a in range(starts[node ^ 1], starts[(node ^ 1) + 1]):
            if to_ends[a] >> 1 <= node >> 1:
                continue
            for b in range(starts[to_ends[a] ^ 1], starts[(to_ends[a] ^ 1) + 1]):
                if to_ends[b] >> 1 > node >> 1 and _side_length(graph, a, b) > 0.0:
                    count = _close_cycles(graph, node, a, b, closing_links, cycles, count)
        for c in range(graph.incoming_starts[node], graph.incoming_starts[node + 1]):
            closing_links[graph.from_ends[graph.incoming[c]] ^ 1] = -1
    return Cycles(cycles.entry_ends[:count].copy(), cycles.corners[:count].copy(), cycles.seen[:count].copy())


@njit(cache=True, error_model='numpy')
def _mark_closing_links(graph: CornerGraph, node: int, closing_links: Ints) -> bool:
    """Write the link to a node by the end where its segment was entered; return whether there is any."""
    is_any = False
    for c in range(graph.incoming_starts[node], graph.incoming_starts[node + 1]):
        link = graph.incoming[c]
        closing_links[graph.from_ends[link] ^ 1] = link
        is_any |= graph.from_ends[link] >> 1 > node >> 1
    return is_any


@njit(cache=True, error_model='numpy')
def _close_cycles(
    graph: CornerGraph, node: int, a: int, b: int, closing_links: Ints, cycles: Cycles, count: int
) -> int:
    """Add the cycles that start with a node and two links; return the new count."""
    to_ends = graph.to_ends
    for c in range(graph.starts[to_ends[b] ^ 1], graph.starts[(to_ends[b] ^ 1) + 1]):
        last = to_ends[c]
        d = closing_links[last]
        if d < 0 or last >> 1 <= node >> 1 or last >> 1 == to_ends[a] >> 1 or count == len(cycles.seen):
            continue
        # Segments entered at their first end have the bright side on the right.
        forward = 4 - (node & 1) - (to_ends[a] & 1) - (to_ends[b] & 1) - (last & 1)
        seen = _seen_fraction(graph, a, b, c, d)
        if min(forward, 4 - forward) > _REVERSED_SIDES_MAX or seen < graph.outline_seen_min:
            continue
        for k, link in enumerate((d, a, b, c)):
            cycles.entry_ends[count, k], cycles.corners[count, k] = to_ends[link], graph.vertices[link]
        cycles.seen[count] = seen
        count += 1
    return count


@njit(cache=True, error_model='numpy')
def _side_length(graph: CornerGraph, before: int, after: int) -> float:
    """Return the length of a side between two links [px], 0 if too little of it is visible."""
    length = graph.exit_positions[after] - graph.entry_positions[before]
    return max(length, 0.0) if graph.support[graph.to_ends[before] >> 1] >= graph.side_seen_min * length else 0.0


@njit(cache=True, error_model='numpy')
def _seen_fraction(graph: CornerGraph, a: int, b: int, c: int, d: int) -> float:
    """Return the visible fraction of the outline of four links, 0 if a side is not visible enough."""
    outline, found = 0.0, 0.0
    for before, after in ((d, a), (a, b), (b, c), (c, d)):
        length = _side_length(graph, before, after)
        if length <= 0.0:
            return 0.0
        outline += length
        found += min(length, graph.support[graph.to_ends[before] >> 1])
    return found / outline


@njit(cache=True, error_model='numpy')
def suppress_duplicates(outlines: Floats, order: Ints, distance: float) -> Ints:
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
def _is_new(outlines: Floats, k: int, kept: Ints, column: int, last: Ints, before: Ints, distance: float) -> bool:
    for near in range(column - 1, column + 2):
        number = last[near]
        while number >= 0:
            if _are_near(outlines[kept[number]], outlines[k], distance):
                return False
            number = before[number]
    return True


@njit(cache=True, error_model='numpy')
def _are_near(one: Floats, other: Floats, distance: float) -> bool:
    largest = 0.0
    for c in range(len(one)):
        largest = max(largest, abs(one[c] - other[c]))
    return largest < distance


@njit(cache=True, error_model='numpy')
def compare_corners(found: Floats, taught: Floats, size_tolerance: float, shape_tolerance: float) -> Floats:
    """Return the differences of detected quadrilaterals from taught ones, shape (k, n); 1 is at the tolerance.

    Args:
        found: vectors from the centre to the four corners [px] and polarity, shape (n, 9).
        taught: parameters of the taught quadrilaterals, shape (k, 9).
        size_tolerance: tolerance of the logarithm of the size.
        shape_tolerance: tolerance of a corner after scaling both to the same size, as a fraction of the size.
    """
    differences = np.full((len(taught), len(found)), np.inf)
    sizes = np.empty(len(found))
    for i in range(len(found)):
        sizes[i] = corner_norm(found[i])
    for k in range(len(taught)):
        size = corner_norm(taught[k])
        for i in range(len(found)):
            if found[i, 8] != taught[k, 8]:
                continue
            scale = sizes[i] / size
            by_size = abs(np.log(scale)) / size_tolerance
            # Beyond the size tolerance the corner order does not matter.
            if by_size > 1.0:
                differences[k, i] = by_size
                continue
            rotation = best_corner_rotation(found[i], taught[k])
            shift = _largest_corner_distance(found[i], taught[k], rotation, scale)
            differences[k, i] = max(by_size, shift / (0.5 * size * shape_tolerance))
    return differences


@njit(cache=True, error_model='numpy')
def best_corner_rotation(found: Floats, taught: Floats) -> int:
    """Return which corner of a detected quadrilateral matches the first corner of a taught one.

    Args:
        found: parameters of the detected quadrilateral, starting with its corner vectors [px], shape (9,).
        taught: parameters of the taught quadrilateral, shape (9,).
    """
    best, most = 0, -np.inf
    for rotation in range(4):
        # The norms are fixed, so the distance is smallest where the dot product is largest.
        product = 0.0
        for c in range(8):
            product += found[(c + 2 * rotation) % 8] * taught[c]
        if product > most:
            best, most = rotation, product
    return best


@njit(cache=True, error_model='numpy')
def order_corner_pairs(left: Floats, right: Floats, taught: Floats) -> Floats:
    """Return the corner vectors in both images in the order of a taught quadrilateral, shape (n, 4, 4) [px].

    Args:
        left: parameters of quadrilaterals in the left image, shape (n, 9).
        right: parameters of the matching quadrilaterals in the right image, shape (n, 9).
        taught: parameters of the taught quadrilateral, shape (9,).
    """
    vectors = np.empty((len(left), 4, 4))
    for i in range(len(left)):
        rotation = best_corner_rotation(left[i], taught)
        other = (rotation + best_corner_rotation(right[i], left[i])) % 4
        for c in range(4):
            for axis in range(2):
                vectors[i, c, axis] = left[i, (2 * (c + rotation) + axis) % 8]
                vectors[i, c, 2 + axis] = right[i, (2 * (c + other) + axis) % 8]
    return vectors


@njit(cache=True, error_model='numpy')
def corner_norm(vectors: Floats) -> float:
    """Return the Frobenius norm of the corner vectors of a quadrilateral, shape (9,) [px]."""
    total = 0.0
    for c in range(8):
        total += vectors[c] ** 2
    return np.sqrt(total)


@njit(cache=True, error_model='numpy')
def _largest_corner_distance(found: Floats, taught: Floats, rotation: int, scale: float) -> float:
    largest = 0.0
    for c in range(4):
        f = (2 * c + 2 * rotation) % 8
        dx, dy = found[f] / scale - taught[2 * c], found[f + 1] / scale - taught[2 * c + 1]
        largest = max(largest, np.sqrt(dx * dx + dy * dy))
    return largest
