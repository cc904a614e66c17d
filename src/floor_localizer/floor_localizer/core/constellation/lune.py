"""Constellations of a baseline: four dots in its lune, no two of them farther apart than the baseline's ends.

The lune is the intersection of the discs around both ends through the other end. Map and view are enumerated by the
same rule, so that the index contains what a view looks up.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import INNER_DOTS

MAX_QUADRUPLES = 1024


@njit(cache=True)
def distance(points: NDArray[np.float64], i: int, j: int) -> float:
    """Return the distance between two dots [m]."""
    dx = np.float64(points[i, 0]) - np.float64(points[j, 0])
    dy = np.float64(points[i, 1]) - np.float64(points[j, 1])
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True)
def dots_in_lune(
    points: NDArray[np.float64],
    first: int,
    second: int,
    neighbours: NDArray[np.int64],
    longest: float,
    lune: NDArray[np.int64],
) -> int:
    """Write the dots within ``longest`` of both ends of a baseline, and return their number.

    Args:
        points: shape (n, 2), dots [m].
        first: index of one end of the baseline.
        second: index of the other end.
        neighbours: candidate dots, sorted by distance from the first end.
        longest: maximum distance between two dots of a constellation [m].
        lune: shape (m,), output; dots beyond its size are left out.
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
def list_quadruples(
    points: NDArray[np.float64], lune: NDArray[np.int64], longest: float, quadruples: NDArray[np.int64]
) -> int:
    """Write all quadruples of dots of a lune with mutual distances up to ``longest``, and return their number.

    Args:
        points: shape (n, 2), dots [m].
        lune: shape (m,), dots in the lune.
        longest: maximum distance between two dots [m].
        quadruples: shape (MAX_QUADRUPLES, 4), output; quadruples beyond its size are left out.
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
def _close_pairs(points: NDArray[np.float64], lune: NDArray[np.int64], longest: float) -> NDArray[np.int64]:
    """Return a bit mask for each dot of a lune: the dots before it that are within ``longest`` [m]."""
    adjacency = np.zeros(len(lune), dtype=np.int64)
    for i in range(len(lune)):
        for j in range(i):
            if distance(points, lune[i], lune[j]) <= longest:
                adjacency[i] |= 1 << j
    return adjacency
