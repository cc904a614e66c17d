"""How densely a map is indexed. Depends only on the number of its dots, so that its parts can be indexed separately."""

from __future__ import annotations

import math
from typing import NamedTuple

from floor_localizer.core.constellation.constellation_key import cell_step
from floor_localizer.core.constellation.index_entry import DOTS_MAX
from floor_localizer.core.floor_localizer_error import FloorLocalizerError

LARGE_MAP = 5_000_000
"""Maps with more dots are indexed more sparsely, and are not searched by pairs of dots."""
# Maximum length of a baseline [mean dot spacings].
_MAX_BASELINE = 3.0


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
    """Return how a map is indexed, from the number of its dots only: its parts can be indexed separately.

    Args:
        dots: number of dots.
        cell: side of the grid's cells [m].

    Raises:
        FloorLocalizerError: there are more dots than an entry can address.
    """
    if dots > DOTS_MAX:
        raise FloorLocalizerError(
            f'{dots} dots are too many for one map, {DOTS_MAX} fit; split it into several'
        )
    budget = _LARGE if dots > LARGE_MAP else _SMALL
    keys = int(budget.keys_per_dot * dots)
    buckets = max(math.ceil(keys / budget.keys_per_bucket), 1)
    return IndexRules(budget.stride, buckets, cell_step(keys, budget.keys_per_cell), _MAX_BASELINE * cell)
