"""How densely a map is indexed: by the number of its dots alone, so that its parts can be indexed apart."""

from __future__ import annotations

import math
from typing import NamedTuple

from floor_localizer.core.constellation.constellation_key import cell_step
from floor_localizer.core.constellation.index_entry import DOTS_MAX
from floor_localizer.core.floor_localizer_error import FloorLocalizerError

LARGE_MAP = 5_000_000
"""A map of more dots is indexed more sparsely, and pairs are not laid on it."""
# Longest base in units of the mean spacing of dots.
_WIDEST = 3.0


class _Thrift(NamedTuple):
    """How much memory the index of a map may take.

    Attributes:
        stride: of a base with the most dots in its lens, one constellation of so many is indexed.
        keys_per_dot: about so many constellations a dot come of that.
        keys_per_bucket: about so many share a bucket.
        crowding: about so many share a cell.
    """

    stride: int
    keys_per_dot: float
    keys_per_bucket: float
    crowding: float


_SMALL = _Thrift(1, 15.3, 4.0, 0.5)
# Memory is slower than the processor there: fewer, fuller cells.
_LARGE = _Thrift(4, 7.7, 8.0, 2.0)


class IndexRules(NamedTuple):
    """How a map is indexed.

    Attributes:
        stride: of a base with the most dots in its lens, one constellation of so many is indexed.
        buckets: number of buckets.
        step: an eighth of a cell's side in units of the base's length.
        longest: no base is longer [m].
    """

    stride: int
    buckets: int
    step: float
    longest: float


def index_rules(dots: int, cell: float) -> IndexRules:
    """Return how a map is indexed: by the number of its dots alone, so that its parts can be indexed apart.

    Args:
        dots: number of dots.
        cell: side of the grid's cells [m].

    Raises:
        FloorLocalizerError: there are more dots than an entry can name.
    """
    if dots > DOTS_MAX:
        raise FloorLocalizerError(
            f'{dots} dots are too many for one map, {DOTS_MAX} fit; split it into several'
        )
    thrift = _LARGE if dots > LARGE_MAP else _SMALL
    keys = int(thrift.keys_per_dot * dots)
    buckets = max(math.ceil(keys / thrift.keys_per_bucket), 1)
    return IndexRules(thrift.stride, buckets, cell_step(keys, thrift.crowding), _WIDEST * cell)
