"""Pairs of line segments that intersect near their end points, also if the intersection is occluded."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, Ints

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
    """Return the links that are among the ``count`` nearest links of one of their ends, the first of equal ones."""
    kept, gaps = np.zeros(len(links.gaps), dtype=np.bool_), np.abs(links.gaps).sum(axis=1)
    for nodes in (2 * links.lines + links.ends).T:
        order = np.lexsort([gaps, nodes])
        ranks = np.arange(len(order)) - np.searchsorted(nodes[order], nodes[order])
        kept[order[ranks < count]] = True
    return CornerLinks._make(each[kept] for each in links)


def link_corners(ends: Floats, gap_max: float, overshoot_max: float, angle_min: float) -> CornerLinks:
    """Return every pair of end points that form a corner, each pair once.

    Args:
        ends: end points of the line segments, shape (n, 2, 2) [px].
        gap_max: largest gap between an end point and the vertex [px].
        overshoot_max: largest overshoot beyond the vertex [px].
        angle_min: smallest angle between both lines [rad].
    """
    order = np.argsort(ends[:, :, 0].ravel(), kind='stable')
    lines, sides = order // 2, order % 2
    steps = ends[:, 1] - ends[:, 0]
    lengths = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    positions = ends.reshape(-1, 2)[order]
    outward = (2.0 * sides - 1.0)[:, None] * (steps / lengths[:, None])[lines]
    gap_limits = np.minimum(gap_max, np.maximum(lengths, overshoot_max))[lines]
    overshoot_limits = np.minimum(overshoot_max, _OVERSHOOT_FRACTION * lengths)[lines]
    columns = np.vstack([positions.T, outward.T, gap_limits, overshoot_limits])
    pairs, gaps = _find_pairs(columns, lines, 2.0 * gap_max, math.sin(angle_min))
    one, other = outward[pairs].transpose(1, 2, 0)
    # Leave along the first segment, enter the second one against its outward direction.
    turns = np.arctan2(one[1] * other[0] - one[0] * other[1], -(one[0] * other[0] + one[1] * other[1]))
    vertices = positions[pairs[:, 0]] + gaps[:, :1] * outward[pairs[:, 0]]
    return CornerLinks(lines[pairs], sides[pairs], vertices, gaps, turns)


@njit(cache=True, error_model='numpy')
def _find_pairs(columns: Floats, lines: Ints, reach: float, sine_min: float) -> tuple[Ints, Floats]:
    """Return pairs of end points, shape (m, 2), and the distances from their vertex, shape (m, 2) [px].

    Columns are x, y, outward unit vector, largest gap and largest overshoot, by rising x.
    """
    xs, ys, us, vs, gap_limits, overshoot_limits = columns
    capacity = 8 * len(xs) + 16
    pairs, gaps, count = np.empty((capacity, 2), np.int64), np.empty((capacity, 2)), 0
    for a in range(len(xs)):
        end = np.searchsorted(xs, xs[a] + reach, side='right') if count < capacity else a
        for b in range(a + 1, end):
            dx, dy, near = xs[b] - xs[a], ys[b] - ys[a], gap_limits[a] + gap_limits[b]
            if abs(dy) > near or dx > near or lines[a] == lines[b] or count == capacity:
                continue
            cross = us[a] * vs[b] - vs[a] * us[b]
            gap, other_gap = (dx * vs[b] - dy * us[b]) / cross, (dx * vs[a] - dy * us[a]) / cross
            is_mine = -overshoot_limits[a] <= gap <= gap_limits[a]
            if is_mine and -overshoot_limits[b] <= other_gap <= gap_limits[b] and abs(cross) >= sine_min:
                pairs[count, 0], pairs[count, 1], gaps[count, 0], gaps[count, 1] = a, b, gap, other_gap
                count += 1
    return pairs[:count].copy(), gaps[:count].copy()
