"""Search for the pose near a prior: only map dots around the predicted positions of a pair are tested."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import GATE, verify_hypothesis
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.lune import distance
from floor_localizer.core.constellation.pair_search import choose_pairs
from floor_localizer.core.constellation.search_state import SearchState, score_hypothesis
from floor_localizer.core.constellation.view_dots import ViewDots

_SHORTEST, _LONGEST = 1.2, 5.0
_MAX_CANDIDATES = 20000
# Above this yaw tolerance [rad] the second dot of a pair is searched in all directions.
_ANY_YAW = 0.5


@njit(cache=True)
def search_near(
    grid: DotGrid,
    view: ViewDots,
    search: SearchState,
    expected: NDArray[np.float64],
    radius: float,
    yaw_tolerance: float,
    max_pairs: int,
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
    starts, ends = np.empty(_MAX_CANDIDATES, np.int64), np.empty(_MAX_CANDIDATES, np.int64)
    seeds = np.empty(2, np.int64)
    position_tolerance = GATE * view.sigma
    for first, second in choose_pairs(view, _SHORTEST * grid.cell, _LONGEST * grid.cell)[:max_pairs]:
        seeds[0], seeds[1] = first, second
        length = distance(view.points, first, second)
        length_tolerance = view.scale_tolerance * length + math.sqrt(2.0) * position_tolerance
        position = a * view.z[first] + b
        displacement = abs(view.z[first]) * (min(yaw_tolerance, 2.0) + view.scale_tolerance)
        around_start = radius + displacement + position_tolerance
        around_end = length * yaw_tolerance + length_tolerance
        count = dots_within(grid, position.real, position.imag, around_start, starts)
        expected_offset = a * (view.z[second] - view.z[first])
        for start in starts[:count]:
            x, y = np.float64(grid.points[start, 0]), np.float64(grid.points[start, 1])
            if yaw_tolerance < _ANY_YAW:
                end_x, end_y = x + expected_offset.real, y + expected_offset.imag
                found = dots_within(grid, end_x, end_y, around_end, ends)
            else:
                found = dots_within(grid, x, y, length + length_tolerance, ends)
            for end in ends[:found]:
                if abs(distance(grid.points, start, end) - length) > length_tolerance:
                    continue
                is_near, rotation, translation = verify_hypothesis(grid, view, seeds, start, end)
                is_near = is_near and _is_expected(view, a, b, rotation, translation, radius, yaw_tolerance)
                if is_near and score_hypothesis(grid, view, search, rotation, translation):
                    return True
    return False


@njit(cache=True)
def _is_expected(
    view: ViewDots,
    a: complex,
    b: complex,
    found_a: complex,
    found_b: complex,
    radius: float,
    yaw_tolerance: float,
) -> bool:
    """Return whether a similarity is within the prior's tolerances, with a margin for its own error."""
    rotation_error = found_a * np.conj(a)
    # A camera height error shifts the base by the same fraction of its distance from the view.
    tolerance = 1.5 * radius + 0.005 + view.scale_tolerance * abs(view.z[0])
    return (
        abs(found_b - b) <= tolerance
        and abs(math.atan2(rotation_error.imag, rotation_error.real)) <= 1.5 * yaw_tolerance + 0.05
    )
