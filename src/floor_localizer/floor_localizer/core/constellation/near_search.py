"""Search for the pose near a prior: only map dots around the predicted positions of a pair are tested."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import GATE, grow
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.lens import distance
from floor_localizer.core.constellation.pair_search import choose_pairs
from floor_localizer.core.constellation.search_state import Search, judge
from floor_localizer.core.constellation.view_dots import ViewDots

_SHORTEST, _LONGEST = 1.2, 5.0
_MOST_AROUND = 20000
# Above this yaw tolerance [rad] the second dot of a pair is searched in all directions.
_ANY_TURN = 0.5


@njit(cache=True)
def search_near(
    grid: DotGrid,
    view: ViewDots,
    search: Search,
    expected: NDArray[np.float64],
    radius: float,
    turn: float,
    most_pairs: int,
) -> bool:
    """Match pairs of the view to the map dots around their predicted positions, until a pose is accepted.

    Args:
        grid: the map.
        view: the view.
        search: the state of the search.
        expected: shape (3,), x, y [m] and yaw [rad] of the base frame in the map.
        radius: maximum distance of the base from the expected position [m].
        yaw_tolerance: maximum difference from the expected yaw [rad].
        max_pairs: maximum number of pairs to test.
    """
    a = complex(math.cos(expected[2]), math.sin(expected[2]))
    b = complex(expected[0], expected[1])
    around = np.empty(_MOST_AROUND, dtype=np.int64)
    ends = np.empty(_MOST_AROUND, dtype=np.int64)
    seeds = np.empty(2, dtype=np.int64)
    slack = GATE * view.sigma
    for first, second in choose_pairs(view, _SHORTEST * grid.cell, _LONGEST * grid.cell)[:most_pairs]:
        seeds[0], seeds[1] = first, second
        length = distance(view.points, first, second)
        stretch = view.scale_tolerance * length + math.sqrt(2.0) * slack
        place = a * view.z[first] + b
        swing = abs(view.z[first]) * (min(turn, 2.0) + view.scale_tolerance)
        count = dots_within(grid, place.real, place.imag, radius + swing + slack, around)
        arm = a * (view.z[second] - view.z[first])
        for start in around[:count]:
            x, y = np.float64(grid.points[start, 0]), np.float64(grid.points[start, 1])
            if turn < _ANY_TURN:
                found = dots_within(grid, x + arm.real, y + arm.imag, length * turn + stretch, ends)
            else:
                found = dots_within(grid, x, y, length + stretch, ends)
            for end in ends[:found]:
                if abs(distance(grid.points, start, end) - length) > stretch:
                    continue
                good, turned, shift = grow(grid, view, seeds, start, end)
                near = good and _is_near(view, a, b, turned, shift, radius, turn)
                if near and judge(grid, view, search, turned, shift):
                    return True
    return False


@njit(cache=True)
def _is_near(
    view: ViewDots, a: complex, b: complex, found_a: complex, found_b: complex, radius: float, turn: float
) -> bool:
    """Return whether a similarity is within the prior's tolerances, with a margin for its own error."""
    off = found_a * np.conj(a)
    # A camera height error shifts the base by the same fraction of its distance from the view.
    room = 1.5 * radius + 0.005 + view.scale_tolerance * abs(view.z[0])
    return abs(found_b - b) <= room and abs(math.atan2(off.imag, off.real)) <= 1.5 * turn + 0.05
