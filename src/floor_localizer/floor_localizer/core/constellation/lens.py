"""Constellations of a baseline: four dots in its lune, no two of them farther apart than the baseline's ends.

The lune is the intersection of the discs around both ends through the other end. Map and view are enumerated by the
same rule, so that the index contains what a view looks up.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import OTHERS

MOST_GROUPS = 1024


@njit(cache=True)
def distance(points: NDArray[np.float64], i: int, j: int) -> float:
    """Return the distance between two dots [m]."""
    dx = np.float64(points[i, 0]) - np.float64(points[j, 0])
    dy = np.float64(points[i, 1]) - np.float64(points[j, 1])
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True)
def dots_in_lens(
    points: NDArray[np.float64],
    first: int,
    second: int,
    near: NDArray[np.int64],
    longest: float,
    lens: NDArray[np.int64],
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
    most = longest * longest
    x0, y0 = points[first, 0], points[first, 1]
    x1, y1 = points[second, 0], points[second, 1]
    for dot in near:
        x, y = points[dot, 0], points[dot, 1]
        if (x - x0) * (x - x0) + (y - y0) * (y - y0) > most or found == len(lens):
            break
        if dot not in (first, second) and (x - x1) * (x - x1) + (y - y1) * (y - y1) <= most:
            lens[found] = dot
            found += 1
    return found


@njit(cache=True)
def groups_of_four(
    points: NDArray[np.float64], lens: NDArray[np.int64], longest: float, groups: NDArray[np.int64]
) -> int:
    """Write all quadruples of dots of a lune with mutual distances up to ``longest``, and return their number.

    Args:
        points: shape (n, 2), dots [m].
        lune: shape (m,), dots in the lune.
        longest: maximum distance between two dots [m].
        quadruples: shape (MAX_QUADRUPLES, 4), output; quadruples beyond its size are left out.
    """
    together = _close_pairs(points, lens, longest)
    count = 0
    for i in range(OTHERS - 1, len(lens)):
        for j in range(OTHERS - 2, i):
            if not together[i] >> j & 1:
                continue
            both = together[i] & together[j]
            for k in range(OTHERS - 3, j):
                if not both >> k & 1:
                    continue
                all_three = both & together[k]
                for m in range(k):
                    if all_three >> m & 1 and count < len(groups):
                        groups[count, 0], groups[count, 1] = lens[i], lens[j]
                        groups[count, 2], groups[count, 3] = lens[k], lens[m]
                        count += 1
    return count


@njit(cache=True)
def _close_pairs(points: NDArray[np.float64], lens: NDArray[np.int64], longest: float) -> NDArray[np.int64]:
    """Return a bit mask for each dot of a lune: the dots before it that are within ``longest`` [m]."""
    together = np.zeros(len(lens), dtype=np.int64)
    for i in range(len(lens)):
        for j in range(i):
            if distance(points, lens[i], lens[j]) <= longest:
                together[i] |= 1 << j
    return together
