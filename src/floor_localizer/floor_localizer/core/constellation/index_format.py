"""How a map is indexed, and a constellation of the index, packed into 64 bits.

    24 bits: subcell of the key | 5: length of the baseline | 7: its direction | 28: its dot at (0, 0)

The other end of the baseline is the map dot nearest to the point given by length and direction; constellations for
which that is wrong are not indexed.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.constellation.constellation_key import cell_step
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.errors import FloorLocalizerError

DOT_BITS = 28
DOTS_MAX = 1 << DOT_BITS  # a map of more dots cannot be indexed

_DIRECTIONS, _LENGTHS = 128, 32
_DIRECTION_SHIFT = np.uint64(DOT_BITS)
_LENGTH_SHIFT = np.uint64(DOT_BITS + 7)
_SUBCELL_SHIFT = np.uint64(DOT_BITS + 12)
_DOT_MASK = np.uint64(DOTS_MAX - 1)
_DIRECTION_MASK = np.uint64(_DIRECTIONS - 1)
_LENGTH_MASK = np.uint64(_LENGTHS - 1)
# Step of the logarithm of the length; the shortest length is an eighth of the longest.
_LOG_LENGTH_STEP = 3.0 * math.log(2.0) / _LENGTHS
LENGTH_ROUNDING = 0.5 * _LOG_LENGTH_STEP  # maximum relative rounding error of a length
# Search radius for the other end [baseline lengths]: the maximum rounding error and a margin.
_SEARCH_RADIUS = 1.1 * math.hypot(LENGTH_ROUNDING, math.pi / _DIRECTIONS)
LARGE_MAP = 5_000_000  # maps with more dots are indexed more sparsely, and are not searched by pairs of dots
# Maximum length of a baseline [mean dot spacings].
_MAX_BASELINE = 3.0


@njit(cache=True)
def pack_baseline(dx: float, dy: float, longest: float) -> np.uint64:
    """Return the bits of an entry for a baseline, from the dot at (0, 0) to that at (1, 0) by (dx, dy) [m].

    ``longest`` is the maximum length of the index's baselines [m].
    """
    angle = math.atan2(dy, dx) / (2.0 * math.pi)
    direction = math.floor(angle * _DIRECTIONS + 0.5) % _DIRECTIONS
    length = int(math.log(longest / math.sqrt(dx * dx + dy * dy)) / _LOG_LENGTH_STEP)
    packed = np.uint64(min(max(length, 0), _LENGTHS - 1)) << _LENGTH_SHIFT
    return packed | np.uint64(direction) << _DIRECTION_SHIFT


@njit(cache=True)
def pack_entry(subcell: np.uint64, packed_baseline: np.uint64, first: int) -> np.uint64:
    """Return the entry of a constellation, from `pack_subcell`, `pack_baseline` and the index of the dot at (0, 0)."""
    return subcell << _SUBCELL_SHIFT | packed_baseline | np.uint64(first)


@njit(cache=True)
def subcell_of_entry(entry: np.uint64) -> np.uint64:
    """Return the subcell of the key, as `pack_subcell` does."""
    return entry >> _SUBCELL_SHIFT


@njit(cache=True)
def first_dot_of_entry(entry: np.uint64) -> int:
    """Return the index of the dot at (0, 0)."""
    return int(entry & _DOT_MASK)


@njit(cache=True)
def length_of_entry(entry: np.uint64, longest: float) -> float:
    """Return the length of the baseline [m], with a relative error up to `LENGTH_ROUNDING`."""
    return longest * math.exp(-(np.float64((entry >> _LENGTH_SHIFT) & _LENGTH_MASK) + 0.5) * _LOG_LENGTH_STEP)


@njit(cache=True)
def second_dot_of_entry(grid: DotGrid, entry: np.uint64, first: int, longest: float) -> int:
    """Return the index of the dot at (1, 0), or -1 if there is none.

    ``first`` is the dot at (0, 0) in the grid: the map, or the part of it around the baseline.
    """
    length = length_of_entry(entry, longest)
    direction = np.float64((entry >> _DIRECTION_SHIFT) & _DIRECTION_MASK)
    angle = direction * (2.0 * math.pi / _DIRECTIONS)
    x = np.float64(grid.points[first, 0]) + length * math.cos(angle)
    y = np.float64(grid.points[first, 1]) + length * math.sin(angle)
    return nearest_dot(grid, x, y, _SEARCH_RADIUS * length)[0]


class _MemoryBudget(NamedTuple):
    """Memory budget of a map's index.

    Attributes:
        stride: only every stride-th constellation of baselines with the fullest lunes is indexed.
        keys_per_dot: approximate number of constellations per dot.
        keys_per_bucket: mean number of keys per bucket.
        keys_per_cell: mean number of keys per cell.
    """

    stride: int
    keys_per_dot: float
    keys_per_bucket: float
    keys_per_cell: float


_SMALL = _MemoryBudget(1, 15.3, 4.0, 0.5)
# Bound by memory latency: fewer, fuller cells.
_LARGE = _MemoryBudget(4, 7.7, 8.0, 2.0)


class IndexRules(NamedTuple):
    """How a map is indexed.

    Attributes:
        stride: only every stride-th constellation of baselines with the fullest lunes is indexed.
        buckets: number of buckets.
        step: quantization step, an eighth of a cell's side [baseline lengths].
        longest: maximum length of a baseline [m].
    """

    stride: int
    buckets: int
    step: float
    longest: float


def index_rules(dots: int, cell: float) -> IndexRules:
    """Return how a map is indexed, from the number of its dots and the side of its cells [m]; parts are indexed alike.

    Raises:
        FloorLocalizerError: there are more dots than an entry can address.
    """
    if dots > DOTS_MAX:
        raise FloorLocalizerError(f'{dots} dots are too many for one map, {DOTS_MAX} fit; split it into several')
    budget = _LARGE if dots > LARGE_MAP else _SMALL
    keys = int(budget.keys_per_dot * dots)
    buckets = max(math.ceil(keys / budget.keys_per_bucket), 1)
    return IndexRules(budget.stride, buckets, cell_step(keys, budget.keys_per_cell), _MAX_BASELINE * cell)
