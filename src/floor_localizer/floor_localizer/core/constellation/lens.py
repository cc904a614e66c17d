"""Which dots make a constellation on a base: those in its lens, no two of them farther apart than its ends.

Map and view are searched by the same rule, so that what the index holds is what a view asks for.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import OTHERS

MOST_IN_LENS = 24
MOST_GROUPS = 1024


@njit(cache=True)
def distance(points: NDArray[np.float64], i: int, j: int) -> float:
    """Return the distance of two dots [m]."""
    dx = np.float64(points[i, 0]) - np.float64(points[j, 0])
    dy = np.float64(points[i, 1]) - np.float64(points[j, 1])
    return math.sqrt(dx * dx + dy * dy)


@njit(cache=True)
def groups_on_base(
    points: NDArray[np.float64], first: int, second: int, near: NDArray[np.int64], longest: float,
    groups: NDArray[np.int64],
) -> int:
    """Write all groups of four dots that make a constellation with a base, and return their number.

    Args:
        points: shape (n, 2), dots [m].
        first: one end of the base.
        second: the other end.
        near: dots around the first end, where the others are looked for.
        longest: no two dots may be farther apart [m].
        groups: shape (MOST_GROUPS, 4), written; what does not fit is left out.
    """
    lens = np.empty(MOST_IN_LENS, dtype=np.int64)
    together = np.empty(MOST_IN_LENS, dtype=np.int64)
    found = 0
    for dot in near:
        if found == MOST_IN_LENS or dot in (first, second):
            continue
        if distance(points, first, dot) <= longest and distance(points, second, dot) <= longest:
            lens[found] = dot
            together[found] = 0
            for j in range(found):
                if distance(points, dot, lens[j]) <= longest:
                    together[found] |= 1 << j
            found += 1
    return _cliques_of_four(lens, together, found, groups)


@njit(cache=True)
def _cliques_of_four(
    lens: NDArray[np.int64], together: NDArray[np.int64], found: int, groups: NDArray[np.int64]
) -> int:
    """Write the dots of all cliques of four; bit j < i of ``together[i]`` tells whether i and j are compatible."""
    count = 0
    for i in range(OTHERS - 1, found):
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
