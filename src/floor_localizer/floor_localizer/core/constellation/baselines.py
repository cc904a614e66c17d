"""Baselines of a view, and the constellations of a baseline.

A constellation is four dots in the lune of a baseline, no two of them farther apart than the baseline's ends.
The lune is the intersection of the discs around both ends through the other end. Map and view are enumerated by the
same rule, so that the index contains what a view looks up.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.constellation_key import INNER_DOTS
from floor_localizer.core.dots import ViewDots

MAX_QUADRUPLES = 1024
# Baselines with more dots in their lune are skipped: hardly any of their constellations would be complete and indexed.
VIEW_LUNE_DOTS_MAX = 12
# Number of length classes for baselines with equally many dots in their lunes.
_LENGTH_CLASSES = 8


@njit(cache=True)
def distance(points: Floats, i: int, j: int) -> float:
    """Return the distance between two dots [m]."""
    dx = np.float64(points[i, 0]) - np.float64(points[j, 0])
    dy = np.float64(points[i, 1]) - np.float64(points[j, 1])
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True)
def dots_in_lune(points: Floats, first: int, second: int, neighbours: Ints, longest: float, lune: Ints) -> int:
    """Write the dots within ``longest`` [m] of both ends of a baseline to ``lune``, and return their number.

    The candidates, ``neighbours``, are sorted by distance from the first end; dots beyond the size of ``lune`` are left
    out.
    """
    found = 0
    max_squared = longest * longest
    x0, y0 = points[first, 0], points[first, 1]
    x1, y1 = points[second, 0], points[second, 1]
    for dot in neighbours:
        x, y = points[dot, 0], points[dot, 1]
        if (x - x0) * (x - x0) + (y - y0) * (y - y0) > max_squared or found == len(lune):
            break
        if dot not in (first, second) and (x - x1) * (x - x1) + (y - y1) * (y - y1) <= max_squared:
            lune[found] = dot
            found += 1
    return found


@njit(cache=True)
def list_quadruples(points: Floats, lune: Ints, longest: float, quadruples: Ints) -> int:
    """Write all quadruples of dots of a lune with mutual distances up to ``longest`` [m], and return their number.

    Those beyond the size of ``quadruples``, shape (MAX_QUADRUPLES, 4), are left out.
    """
    adjacency = _close_pairs(points, lune, longest)
    count = 0
    for i in range(INNER_DOTS - 1, len(lune)):
        for j in range(INNER_DOTS - 2, i):
            if not adjacency[i] >> j & 1:
                continue
            common = adjacency[i] & adjacency[j]
            for k in range(INNER_DOTS - 3, j):
                if not common >> k & 1:
                    continue
                common_to_three = common & adjacency[k]
                for m in range(k):
                    if common_to_three >> m & 1 and count < len(quadruples):
                        quadruples[count, 0], quadruples[count, 1] = lune[i], lune[j]
                        quadruples[count, 2], quadruples[count, 3] = lune[k], lune[m]
                        count += 1
    return count


@njit(cache=True)
def _close_pairs(points: Floats, lune: Ints, longest: float) -> Ints:
    """Return a bit mask for each dot of a lune: the dots before it that are within ``longest`` [m]."""
    adjacency = np.zeros(len(lune), dtype=np.int64)
    for i in range(len(lune)):
        for j in range(i):
            if distance(points, lune[i], lune[j]) <= longest:
                adjacency[i] |= 1 << j
    return adjacency


class ViewBaselines(NamedTuple):
    """Baselines by lune count, then long to short: ends, (p, 2), lengths, (p,) [m], dots in their lunes, (p,)."""

    ends: Ints
    lengths: Floats
    lune_counts: Ints


@njit(cache=True)
def list_baselines(view: ViewDots, min_length: float, max_length: float) -> ViewBaselines:
    """List the baselines of a view with a length in a range [m] and enough dots for a constellation."""
    n, m = view.neighbours.shape
    baselines = ViewBaselines(np.empty((n * m, 2), dtype=np.int64), np.empty(n * m), np.empty(n * m, dtype=np.int64))
    lune = np.empty(VIEW_LUNE_DOTS_MAX + 1, dtype=np.int64)
    count = 0
    for first in range(n):
        for second in view.neighbours[first, min(INNER_DOTS, m) :]:
            length = distance(view.points, first, second)
            if length > max_length:
                break
            if first > second or length < min_length:
                continue
            inside = dots_in_lune(view.points, first, second, view.neighbours[first], length + 2.0 * view.sigma, lune)
            if INNER_DOTS <= inside <= VIEW_LUNE_DOTS_MAX:
                baselines.ends[count, 0], baselines.ends[count, 1] = first, second
                baselines.lengths[count] = length
                baselines.lune_counts[count] = inside
                count += 1
    order = _sort_order(baselines.lune_counts[:count], baselines.lengths[:count], max_length)
    return ViewBaselines(baselines.ends[order], baselines.lengths[order], baselines.lune_counts[order])


@njit(cache=True)
def _sort_order(lune_counts: Ints, lengths: Floats, max_length: float) -> Ints:
    """Return the order by lune count, then from long to short in classes of length (a counting sort)."""
    starts = np.zeros((VIEW_LUNE_DOTS_MAX + 1) * _LENGTH_CLASSES + 1, dtype=np.int64)
    classes = np.empty(len(lune_counts), dtype=np.int64)
    for k in range(len(lune_counts)):
        length_class = int(_LENGTH_CLASSES * (1.0 - lengths[k] / max_length))
        classes[k] = lune_counts[k] * _LENGTH_CLASSES + min(max(length_class, 0), _LENGTH_CLASSES - 1)
        starts[classes[k] + 1] += 1
    starts = np.cumsum(starts)
    order = np.empty(len(lune_counts), dtype=np.int64)
    for k in range(len(lune_counts)):
        order[starts[classes[k]]] = k
        starts[classes[k]] += 1
    return order
