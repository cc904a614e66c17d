"""Pairs of line segments that intersect near their end points, also if the intersection is occluded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Largest overshoot of a segment beyond the vertex, as a fraction of its length.
_PART = 0.5


class CornerLinks(NamedTuple):
    """Pairs of end points of line segments; end 1 is the last point of a segment.

    Attributes:
        lines: indices of both line segments, shape (n, 2).
        ends: end of each segment, 0 or 1, shape (n, 2).
        vertices: intersections of their lines, shape (n, 2) [px].
        gaps: distances from each end point to the vertex, negative for an overshoot, shape (n, 2) [px].
        turns: turning angles when leaving along the first segment and entering the second, shape (n,) [rad].
    """

    sides: NDArray[np.int64]
    ends: NDArray[np.int64]
    vertices: NDArray[np.float64]
    gaps: NDArray[np.float64]
    turns: NDArray[np.float64]


def nearest_links(links: CornerLinks, count: int) -> CornerLinks:
    """Return the links that are among the nearest links of one of their ends.

    Args:
        links: pairs of end points.
        count: number of links to keep per end.
    """
    nodes = 2 * links.sides + links.ends
    kept = _are_nearest(nodes, np.abs(links.gaps).sum(axis=1), count)
    sides, ends, vertices = links.sides[kept], links.ends[kept], links.vertices[kept]
    return CornerLinks(sides, ends, vertices, links.gaps[kept], links.turns[kept])


@njit(cache=True, error_model='numpy')
def _are_nearest(nodes: NDArray[np.int64], gaps: NDArray[np.float64], count: int) -> NDArray[np.bool_]:
    """Return which links are among the nearest links of one of their ends, the first of equal ones, shape (n,).

    Args:
        nodes: node numbers of both ends, shape (n, 2).
        gaps: gaps of the links, shape (n,) [px].
        count: number of links to keep per end.
    """
    kept = np.zeros(len(gaps), np.bool_)
    if not len(gaps):
        return kept
    # The nearest links of each end so far, sorted.
    best, filled = np.empty((np.max(nodes) + 1, count), np.int64), np.zeros(np.max(nodes) + 1, np.int64)
    for side in range(2):
        filled[:] = 0
        for m in range(len(gaps)):
            node = nodes[m, side]
            place = filled[node]
            if place == count and not gaps[m] < gaps[best[node, count - 1]]:
                continue
            filled[node] = min(place + 1, count)
            place = filled[node] - 1
            while place > 0 and gaps[best[node, place - 1]] > gaps[m]:
                best[node, place] = best[node, place - 1]
                place -= 1
            best[node, place] = m
        for node in range(len(filled)):
            for place in range(filled[node]):
                kept[best[node, place]] = True
    return kept


@njit(cache=True, error_model='numpy')
def link_corners(
    ends: NDArray[np.float64], gap_max: float, overshoot_max: float, angle_min: float
) -> CornerLinks:
    """Return every pair of end points that form a corner, each pair once.

    Args:
        ends: end points of the line segments, shape (n, 2, 2) [px].
        gap_max: largest gap between an end point and the vertex [px].
        overshoot_max: largest overshoot beyond the vertex [px].
        angle_min: smallest angle between both lines [rad].
    """
    n = len(ends)
    order, places, outward, lengths = _by_column(ends)
    members, starts, strips = _by_strip(places[:, 1], gap_max)
    numbers = np.empty(2 * n, np.int64)
    numbers[members] = np.arange(2 * n)
    sides, lengths = order[members] >> 1, lengths[members]
    tips = _Tips(
        *(places[members, 0], places[members, 1], outward[members, 0], outward[members, 1]),
        reaches=np.minimum(gap_max, np.maximum(lengths, overshoot_max)),
        overshoots=np.minimum(overshoot_max, _PART * lengths),
    )
    # Sliding window per strip: first end point right of the present one, and first one out of range.
    nexts, lasts = starts[:-1].copy(), starts[:-1].copy()
    meets = np.empty(2 * n, np.bool_)
    pairs, gaps = np.empty((16 * n + 16, 2), np.int64), np.empty((16 * n + 16, 2))
    count = 0
    for a in range(2 * n):
        nexts[strips[a]] += 1
        i, begin = numbers[a], count
        # Gap limits are at most the height of a strip.
        for strip in range(max(strips[a] - 2, 0), min(strips[a] + 3, len(nexts))):
            while lasts[strip] < starts[strip + 1] and tips.xs[lasts[strip]] - tips.xs[i] <= 2.0 * gap_max:
                lasts[strip] += 1
            _mark_meeting(tips, i, nexts[strip], lasts[strip], np.sin(angle_min), meets)
            for m in range(nexts[strip], lasts[strip]):
                if meets[m] and sides[m] != sides[i] and count < len(pairs):
                    _insert(pairs, gaps, begin, count, (a, members[m]), _gaps_between(tips, i, m))
                    count += 1
    return _described(pairs[:count], gaps[:count], order, places, outward)


class _Tips(NamedTuple):
    """End points of line segments, sorted by strip, then from left to right; each array has shape (n,).

    Attributes:
        xs: x coordinates [px].
        ys: y coordinates [px].
        outward_xs: x components of the outward unit vectors.
        outward_ys: y components of the outward unit vectors.
        gap_limits: largest gaps to a vertex [px].
        overshoot_limits: largest overshoots beyond a vertex [px].
    """

    xs: NDArray[np.float64]
    ys: NDArray[np.float64]
    outward_xs: NDArray[np.float64]
    outward_ys: NDArray[np.float64]
    reaches: NDArray[np.float64]
    overshoots: NDArray[np.float64]


@njit(cache=True, error_model='numpy')
def _mark_meeting(
    tips: _Tips, i: int, begin: int, end: int, sine_min: float, meets: NDArray[np.bool_]
) -> None:
    """Write which end points of a range form a corner with end point i."""
    x, y, u, v = tips.xs[i], tips.ys[i], tips.outward_xs[i], tips.outward_ys[i]
    reach, overshoot = tips.reaches[i], tips.overshoots[i]
    xs, ys, us, vs = (
        tips.xs[begin:end],
        tips.ys[begin:end],
        tips.outward_xs[begin:end],
        tips.outward_ys[begin:end],
    )
    reaches, overshoots, marks = tips.reaches[begin:end], tips.overshoots[begin:end], meets[begin:end]
    for m in range(len(marks)):
        # No branches and divisions, so that the compiler can vectorize the loop.
        dx, dy, cross = xs[m] - x, ys[m] - y, u * vs[m] - v * us[m]
        sine, sign = abs(cross), 1.0 if cross >= 0.0 else -1.0
        mine, other = sign * (dx * vs[m] - dy * us[m]), sign * (dx * v - dy * u)
        near = (abs(dx) <= reach + reaches[m]) & (abs(dy) <= reach + reaches[m]) & (sine >= sine_min)
        is_mine = (mine >= -overshoot * sine) & (mine <= reach * sine)
        marks[m] = near & is_mine & (other >= -overshoots[m] * sine) & (other <= reaches[m] * sine)


@njit(cache=True, error_model='numpy')
def _gaps_between(tips: _Tips, i: int, m: int) -> tuple[float, float]:
    """Return the distances of two end points from the intersection of their lines [px]."""
    dx, dy = tips.xs[m] - tips.xs[i], tips.ys[m] - tips.ys[i]
    u, v, other_u, other_v = tips.outward_xs[i], tips.outward_ys[i], tips.outward_xs[m], tips.outward_ys[m]
    cross = u * other_v - v * other_u
    return (dx * other_v - dy * other_u) / cross, (dx * v - dy * u) / cross


@njit(cache=True, error_model='numpy')
def _by_column(
    ends: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
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
def _by_strip(
    rows: NDArray[np.float64], height: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return indices sorted by strip (stable), the start of each strip, and the strip of each row, shape (n,).

    Args:
        rows: y coordinates, shape (n,) [px].
        height: height of a strip [px].
    """
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
    pairs: NDArray[np.int64],
    gaps: NDArray[np.float64],
    begin: int,
    end: int,
    pair: tuple[int, int],
    between: tuple[float, float],
) -> None:
    """Insert a pair among those with the same first end, by rising number of the second end."""
    place = end
    while place > begin and pairs[place - 1, 1] > pair[1]:
        pairs[place], gaps[place] = pairs[place - 1], gaps[place - 1]
        place -= 1
    pairs[place, 0], pairs[place, 1] = pair
    gaps[place, 0], gaps[place, 1] = between


@njit(cache=True, error_model='numpy')
def _described(
    pairs: NDArray[np.int64],
    gaps: NDArray[np.float64],
    order: NDArray[np.int64],
    places: NDArray[np.float64],
    outward: NDArray[np.float64],
) -> CornerLinks:
    n = len(pairs)
    sides, which = np.empty((n, 2), np.int64), np.empty((n, 2), np.int64)
    vertices, turns = np.empty((n, 2)), np.empty(n)
    for k in range(n):
        a, b = pairs[k]
        for c in range(2):
            sides[k, c], which[k, c] = order[pairs[k, c]] // 2, order[pairs[k, c]] % 2
            vertices[k, c] = places[a, c] + gaps[k, 0] * outward[a, c]
        # Leave along the first segment, enter the second one against its outward direction.
        cross = outward[a, 0] * outward[b, 1] - outward[a, 1] * outward[b, 0]
        turns[k] = np.arctan2(-cross, -(outward[a, 0] * outward[b, 0] + outward[a, 1] * outward[b, 1]))
    return CornerLinks(sides, which, vertices, gaps.copy(), turns)
