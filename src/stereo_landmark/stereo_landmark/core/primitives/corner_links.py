"""Pairs of line segments that intersect near their end points, also if the intersection is occluded."""

from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints, Masks

# Largest overshoot of a segment beyond the vertex, as a fraction of its length.
_OVERSHOOT_FRACTION = 0.5


class CornerLinks(NamedTuple):
    """Pairs of end points of line segments; end 1 is the last point of a segment.

    Attributes:
        lines: indices of both line segments, shape (n, 2).
        ends: end of each segment, 0 or 1, shape (n, 2).
        vertices: intersections of their lines, shape (n, 2) [px].
        gaps: distances from each end point to the vertex, negative for an overshoot, shape (n, 2) [px].
        turns: turning angles when leaving along the first segment and entering the second, shape (n,) [rad].
    """

    lines: Ints
    ends: Ints
    vertices: Floats
    gaps: Floats
    turns: Floats


def nearest_links(links: CornerLinks, count: int) -> CornerLinks:
    """Return the links that are among the ``count`` nearest links of one of their ends."""
    kept = _are_nearest(2 * links.lines + links.ends, np.abs(links.gaps).sum(axis=1), count)
    lines, ends, vertices = links.lines[kept], links.ends[kept], links.vertices[kept]
    return CornerLinks(lines, ends, vertices, links.gaps[kept], links.turns[kept])


@njit(cache=True, error_model='numpy')
def _are_nearest(nodes: Ints, gaps: Floats, count: int) -> Masks:
    """Return which links are among the nearest links of one of their ends, the first of equal ones, shape (n,)."""
    kept = np.zeros(len(gaps), np.bool_)
    if not len(gaps):
        return kept
    # The nearest links of each end so far, sorted.
    best, filled = np.empty((np.max(nodes) + 1, count), np.int64), np.zeros(np.max(nodes) + 1, np.int64)
    for side in range(2):
        filled[:] = 0
        for m in range(len(gaps)):
            node = nodes[m, side]
            slot = filled[node]
            if slot == count and not gaps[m] < gaps[best[node, count - 1]]:
                continue
            filled[node] = min(slot + 1, count)
            slot = filled[node] - 1
            while slot > 0 and gaps[best[node, slot - 1]] > gaps[m]:
                best[node, slot] = best[node, slot - 1]
                slot -= 1
            best[node, slot] = m
        for node in range(len(filled)):
            for slot in range(filled[node]):
                kept[best[node, slot]] = True
    return kept


@njit(cache=True, error_model='numpy')
def link_corners(ends: Floats, gap_max: float, overshoot_max: float, angle_min: float) -> CornerLinks:
    """Return every pair of end points that form a corner, each pair once.

    Args:
        ends: end points of the line segments, shape (n, 2, 2) [px].
        gap_max: largest gap between an end point and the vertex [px].
        overshoot_max: largest overshoot beyond the vertex [px].
        angle_min: smallest angle between both lines [rad].
    """
    n = len(ends)
    order, positions, outward, lengths = _sort_by_x(ends)
    members, starts, strips = _sort_by_strip(positions[:, 1], gap_max)
    numbers = np.empty(2 * n, np.int64)
    numbers[members] = np.arange(2 * n)
    lines, lengths = order[members] >> 1, lengths[members]
    end_points = _EndPoints(
        *(positions[members, 0], positions[members, 1], outward[members, 0], outward[members, 1]),
        gap_limits=np.minimum(gap_max, np.maximum(lengths, overshoot_max)),
        overshoot_limits=np.minimum(overshoot_max, _OVERSHOOT_FRACTION * lengths),
    )
    # Sliding window per strip: first end point right of the present one, and first one out of range.
    window_begins, window_ends = starts[:-1].copy(), starts[:-1].copy()
    is_intersecting = np.empty(2 * n, np.bool_)
    pairs, gaps = np.empty((16 * n + 16, 2), np.int64), np.empty((16 * n + 16, 2))
    count = 0
    for a in range(2 * n):
        window_begins[strips[a]] += 1
        i, begin = numbers[a], count
        # Gap limits are at most the height of a strip.
        for strip in range(max(strips[a] - 2, 0), min(strips[a] + 3, len(window_begins))):
            while (
                window_ends[strip] < starts[strip + 1]
                and end_points.xs[window_ends[strip]] - end_points.xs[i] <= 2.0 * gap_max
            ):
                window_ends[strip] += 1
            _mark_intersecting(
                end_points, i, window_begins[strip], window_ends[strip], np.sin(angle_min), is_intersecting
            )
            for m in range(window_begins[strip], window_ends[strip]):
                if is_intersecting[m] and lines[m] != lines[i] and count < len(pairs):
                    _insert(pairs, gaps, begin, count, (a, members[m]), _gaps_between(end_points, i, m))
                    count += 1
    return _make_links(pairs[:count], gaps[:count], order, positions, outward)


class _EndPoints(NamedTuple):
    """End points of line segments, sorted by strip, then from left to right; each array has shape (n,).

    Attributes:
        xs: x coordinates [px].
        ys: y coordinates [px].
        outward_xs: x components of the outward unit vectors.
        outward_ys: y components of the outward unit vectors.
        gap_limits: largest gaps to a vertex [px].
        overshoot_limits: largest overshoots beyond a vertex [px].
    """

    xs: Floats
    ys: Floats
    outward_xs: Floats
    outward_ys: Floats
    gap_limits: Floats
    overshoot_limits: Floats


@njit(cache=True, error_model='numpy')
def _mark_intersecting(
    end_points: _EndPoints, i: int, begin: int, end: int, sine_min: float, is_intersecting: Masks
) -> None:
    """Write which end points of a range form a corner with end point i."""
    x, y, u, v = end_points.xs[i], end_points.ys[i], end_points.outward_xs[i], end_points.outward_ys[i]
    gap_limit, overshoot_limit = end_points.gap_limits[i], end_points.overshoot_limits[i]
    xs, ys = end_points.xs[begin:end], end_points.ys[begin:end]
    us, vs = end_points.outward_xs[begin:end], end_points.outward_ys[begin:end]
    gap_limits, overshoot_limits = end_points.gap_limits[begin:end], end_points.overshoot_limits[begin:end]
    marks = is_intersecting[begin:end]
    for m in range(len(marks)):
        # No branches and divisions, so that the compiler can vectorize the loop.
        dx, dy, cross = xs[m] - x, ys[m] - y, u * vs[m] - v * us[m]
        sine, sign = abs(cross), 1.0 if cross >= 0.0 else -1.0
        gap, other_gap = sign * (dx * vs[m] - dy * us[m]), sign * (dx * v - dy * u)
        near = (abs(dx) <= gap_limit + gap_limits[m]) & (abs(dy) <= gap_limit + gap_limits[m]) & (sine >= sine_min)
        is_mine = (gap >= -overshoot_limit * sine) & (gap <= gap_limit * sine)
        marks[m] = near & is_mine & (other_gap >= -overshoot_limits[m] * sine) & (other_gap <= gap_limits[m] * sine)


@njit(cache=True, error_model='numpy')
def _gaps_between(end_points: _EndPoints, i: int, m: int) -> tuple[float, float]:
    """Return the distances of two end points from the intersection of their lines [px]."""
    dx, dy = end_points.xs[m] - end_points.xs[i], end_points.ys[m] - end_points.ys[i]
    u, v = end_points.outward_xs[i], end_points.outward_ys[i]
    other_u, other_v = end_points.outward_xs[m], end_points.outward_ys[m]
    cross = u * other_v - v * other_u
    return (dx * other_v - dy * other_u) / cross, (dx * v - dy * u) / cross


@njit(cache=True, error_model='numpy')
def _sort_by_x(ends: Floats) -> tuple[Ints, Floats, Floats, Floats]:
    """Return all end points from left to right: node number, position [px], outward unit vector, line length [px]."""
    n = len(ends)
    outward, lengths = np.empty((2 * n, 2)), np.empty(2 * n)
    for i in range(n):
        dx, dy = ends[i, 1] - ends[i, 0]
        length = np.sqrt(dx * dx + dy * dy)
        for e in range(2):
            sign = 2.0 * e - 1.0
            outward[2 * i + e, 0], outward[2 * i + e, 1] = sign * dx / length, sign * dy / length
            lengths[2 * i + e] = length
    order = np.argsort(ends[:, :, 0].copy().reshape(2 * n))
    return order, ends.copy().reshape(2 * n, 2)[order], outward[order], lengths[order]


@njit(cache=True, error_model='numpy')
def _sort_by_strip(rows: Floats, height: float) -> tuple[Ints, Ints, Ints]:
    """Return indices sorted by strip (stable), the start of each strip, and the strip of each row, shape (n,)."""
    n = len(rows)
    strips = np.empty(n, np.int64)
    if not n:
        return strips, np.zeros(1, np.int64), strips
    top = np.min(rows)
    for i in range(n):
        strips[i] = int((rows[i] - top) / height)
    starts = np.zeros(np.max(strips) + 2, np.int64)
    for i in range(n):
        starts[strips[i] + 1] += 1
    starts = np.cumsum(starts)
    filled, members = starts.copy(), np.empty(n, np.int64)
    for i in range(n):
        members[filled[strips[i]]] = i
        filled[strips[i]] += 1
    return members, starts, strips


@njit(cache=True, error_model='numpy')
def _insert(
    pairs: Ints, gaps: Floats, begin: int, end: int, pair: tuple[int, int], between: tuple[float, float]
) -> None:
    """Insert a pair among those with the same first end, by rising number of the second end."""
    slot = end
    while slot > begin and pairs[slot - 1, 1] > pair[1]:
        pairs[slot], gaps[slot] = pairs[slot - 1], gaps[slot - 1]
        slot -= 1
    pairs[slot, 0], pairs[slot, 1] = pair
    gaps[slot, 0], gaps[slot, 1] = between


@njit(cache=True, error_model='numpy')
def _make_links(pairs: Ints, gaps: Floats, order: Ints, positions: Floats, outward: Floats) -> CornerLinks:
    n = len(pairs)
    lines, end_numbers = np.empty((n, 2), np.int64), np.empty((n, 2), np.int64)
    vertices, turns = np.empty((n, 2)), np.empty(n)
    for k in range(n):
        a, b = pairs[k]
        for c in range(2):
            lines[k, c], end_numbers[k, c] = order[pairs[k, c]] // 2, order[pairs[k, c]] % 2
            vertices[k, c] = positions[a, c] + gaps[k, 0] * outward[a, c]
        # Leave along the first segment, enter the second one against its outward direction.
        cross = outward[a, 0] * outward[b, 1] - outward[a, 1] * outward[b, 0]
        turns[k] = np.arctan2(-cross, -(outward[a, 0] * outward[b, 0] + outward[a, 1] * outward[b, 1]))
    return CornerLinks(lines, end_numbers, vertices, gaps.copy(), turns)
