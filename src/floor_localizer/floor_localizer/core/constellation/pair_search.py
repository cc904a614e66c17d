"""Match pairs of view dots to pairs of map dots: slower than the index, but two dots suffice.

Fallback for views with so many missing dots that no constellation is complete.
"""

import math

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.constellation.acceptance import BEST, SearchState, is_accepted, score_hypothesis
from floor_localizer.core.constellation.alignment import GATE, verify_hypothesis
from floor_localizer.core.constellation.baselines import distance
from floor_localizer.core.constellation.dot_grid import DotGrid, dots_within
from floor_localizer.core.constellation.indexed_map import OccupancyBitmap, is_occupied
from floor_localizer.core.dots import ViewDots

# Length of pairs [mean dot spacings]: shorter pairs leave the yaw too uncertain, longer ones match too many map pairs.
_SHORTEST, _LONGEST = 1.0, 2.0
# A view of few dots may have hardly any such pair of right dots: then up to so many pairs, and as long.
_PAIRS_MIN, _LONGEST_SPARSE = 16, 3.0
# Number of neighbours of a pair that are looked up, and number of misses that reject a hypothesis.
_CHECKED_NEIGHBOURS, _MAX_MISSES = 6, 4
_SHORTEST_NEAR, _LONGEST_NEAR = 1.2, 5.0
_MAX_CANDIDATES = 20000
# Above this yaw tolerance [rad] the second dot of a pair is searched in all directions.
_ANY_YAW = 0.5


@njit(cache=True)
def search_pairs(
    grid: DotGrid, occupancy: OccupancyBitmap, view: ViewDots, search: SearchState, max_pairs: int
) -> bool:
    """Match up to ``max_pairs`` pairs of the view to the map until a pose is accepted; none without a bitmap."""
    if occupancy.bits.size == 0:
        return False
    seeds = np.empty(2, dtype=np.int64)
    pairs = choose_pairs(view, _SHORTEST * grid.cell, _LONGEST * grid.cell)
    if len(pairs) < _PAIRS_MIN:
        longer = choose_pairs(view, _LONGEST * grid.cell, _LONGEST_SPARSE * grid.cell)
        pairs = np.concatenate((pairs, longer[: _PAIRS_MIN - len(pairs)]))
    for first, second in pairs[:max_pairs]:
        seeds[0], seeds[1] = first, second
        _match_pair_to_map(grid, occupancy, view, search, seeds)
        if is_accepted(search, search.poses[BEST]):
            return True
    return False


@njit(cache=True)
def choose_pairs(view: ViewDots, shortest: float, longest: float) -> Ints:
    """List the pairs of dots with a length in a range [m], shape (p, 2), pairs of unused dots first."""
    n, m = view.neighbours.shape
    pairs = np.empty((n * m, 2), dtype=np.int64)
    uses = np.empty(n * m)
    used = np.zeros(n)
    count = 0
    for turn in range(m):
        for first in range(n):
            second = view.neighbours[first, turn]
            length = distance(view.points, first, second)
            if first < second and shortest <= length <= longest:
                pairs[count, 0], pairs[count, 1] = first, second
                uses[count] = max(used[first], used[second])
                used[first] += 1.0
                used[second] += 1.0
                count += 1
    return pairs[np.argsort(uses[:count])]


@njit(cache=True)
def _match_pair_to_map(
    grid: DotGrid, occupancy: OccupancyBitmap, view: ViewDots, search: SearchState, seeds: Ints
) -> None:
    """Match one pair of the view to all map pairs of its length, without stopping early, to detect ambiguity."""
    length = distance(view.points, seeds[0], seeds[1])
    length_tolerance = view.scale_tolerance * length + math.sqrt(2.0) * GATE * view.sigma
    neighbour_offsets = _neighbour_offsets(view, seeds)
    min_squared, max_squared = max(length - length_tolerance, 0.0) ** 2, (length + length_tolerance) ** 2
    cell_radius = int(math.sqrt(max_squared) / grid.cell) + 1
    for row in range(grid.rows):
        first_row, last_row = max(row - cell_radius, 0), min(row + cell_radius, grid.rows - 1)
        for column in range(grid.columns):
            cell = row * grid.columns + column
            first_column, last_column = (max(column - cell_radius, 0), min(column + cell_radius, grid.columns - 1))
            for a in range(np.int64(grid.starts[cell]), np.int64(grid.starts[cell + 1])):
                x, y = grid.points[a, 0], grid.points[a, 1]
                for other_row in range(first_row, last_row + 1):
                    start = np.int64(grid.starts[other_row * grid.columns + first_column])
                    end = np.int64(grid.starts[other_row * grid.columns + last_column + 1])
                    for b in range(start, end):
                        dx, dy = grid.points[b, 0] - x, grid.points[b, 1] - y
                        if not min_squared <= dx * dx + dy * dy <= max_squared:
                            continue
                        search.counts[1] += 1
                        if not _has_neighbours_on_map(occupancy, neighbour_offsets, x, y, dx, dy):
                            continue
                        is_supported, turn, shift = verify_hypothesis(grid, view, seeds, a, b)
                        if is_supported:
                            score_hypothesis(grid, view, search, turn, shift)


@njit(cache=True)
def _neighbour_offsets(view: ViewDots, seeds: Ints) -> Complexes:
    """Return the positions of the neighbours of a pair in the pair's frame: first dot at 0, second at 1."""
    zi, zj = view.z[seeds[0]], view.z[seeds[1]]
    distances = np.abs(view.z - 0.5 * (zi + zj))
    distances[seeds[0]] = distances[seeds[1]] = math.inf
    neighbours = np.argsort(distances)[: min(_CHECKED_NEIGHBOURS, len(distances) - 2)]
    return (view.z[neighbours] - zi) / (zj - zi)


@njit(cache=True)
def _has_neighbours_on_map(
    occupancy: OccupancyBitmap, neighbour_offsets: Complexes, x: float, y: float, dx: float, dy: float
) -> bool:
    """Return whether enough neighbours of a pair are on the map when the pair is at (x, y) and (x+dx, y+dy)."""
    misses = 0
    for g in neighbour_offsets:
        if not is_occupied(occupancy, x + g.real * dx - g.imag * dy, y + g.imag * dx + g.real * dy):
            misses += 1
            if misses >= _MAX_MISSES:
                return False
    return True


@njit(cache=True)
def search_near(
    grid: DotGrid,
    view: ViewDots,
    search: SearchState,
    expected: Floats,
    radius: float,
    yaw_tolerance: float,
    max_pairs: int,
) -> bool:
    """Match pairs of the view to the map dots around their predicted positions, until a pose is accepted.

    Up to ``max_pairs`` pairs are tested. The base is expected at x, y [m] and yaw [rad] in the map, shape (3,), within
    a radius [m] and a tolerance of its yaw [rad].
    """
    a = complex(math.cos(expected[2]), math.sin(expected[2]))
    b = complex(expected[0], expected[1])
    starts, ends = np.empty(_MAX_CANDIDATES, np.int64), np.empty(_MAX_CANDIDATES, np.int64)
    seeds = np.empty(2, np.int64)
    position_tolerance = GATE * view.sigma
    for first, second in choose_pairs(view, _SHORTEST_NEAR * grid.cell, _LONGEST_NEAR * grid.cell)[:max_pairs]:
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
    view: ViewDots, a: complex, b: complex, found_a: complex, found_b: complex, radius: float, yaw_tolerance: float
) -> bool:
    """Return whether a similarity is within the prior's tolerances, with a margin for its own error."""
    rotation_error = found_a * np.conj(a)
    # A camera height error shifts the base by the same fraction of its distance from the view.
    tolerance = 1.5 * radius + 0.005 + view.scale_tolerance * abs(view.z[0])
    return (
        abs(found_b - b) <= tolerance
        and abs(math.atan2(rotation_error.imag, rotation_error.real)) <= 1.5 * yaw_tolerance + 0.05
    )
