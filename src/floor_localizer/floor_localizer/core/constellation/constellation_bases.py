"""The baselines of a view, in the order in which their constellations are looked up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import OTHERS
from floor_localizer.core.constellation.lens import distance, dots_in_lens
from floor_localizer.core.constellation.view_dots import ViewDots

# Baselines with more dots in their lune are skipped: hardly any of their constellations would be complete and indexed.
MOST_CROWDED = 12
# Number of length classes for baselines with equally many dots in their lunes.
_LENGTHS = 8


class ViewBases(NamedTuple):
    """Baselines of a view, sorted by the number of dots in their lunes, then from long to short.

    Attributes:
        ends: shape (p, 2), dots at both ends.
        lengths: shape (p,), lengths [m].
        lune_counts: shape (p,), numbers of dots in the lunes.
    """

    ends: NDArray[np.int64]
    lengths: NDArray[np.float64]
    crowds: NDArray[np.int64]


@njit(cache=True)
def list_bases(view: ViewDots, shortest: float, longest: float) -> ViewBases:
    """List the baselines of a view with a length in a range [m] and enough dots for a constellation."""
    n, m = view.nearest.shape
    bases = ViewBases(np.empty((n * m, 2), dtype=np.int64), np.empty(n * m), np.empty(n * m, dtype=np.int64))
    lens = np.empty(MOST_CROWDED + 1, dtype=np.int64)
    count = 0
    for first in range(n):
        for second in view.nearest[first, min(OTHERS, m) :]:
            length = distance(view.points, first, second)
            if length > longest:
                break
            if first > second or length < shortest:
                continue
            inside = dots_in_lens(
                view.points, first, second, view.nearest[first], length + 2.0 * view.sigma, lens
            )
            if OTHERS <= inside <= MOST_CROWDED:
                bases.ends[count, 0], bases.ends[count, 1] = first, second
                bases.lengths[count] = length
                bases.crowds[count] = inside
                count += 1
    order = _order(bases.crowds[:count], bases.lengths[:count], longest)
    return ViewBases(bases.ends[order], bases.lengths[order], bases.crowds[order])


@njit(cache=True)
def _order(crowds: NDArray[np.int64], lengths: NDArray[np.float64], longest: float) -> NDArray[np.int64]:
    """Return the order by lune count, then from long to short in classes of length (a counting sort)."""
    starts = np.zeros((MOST_CROWDED + 1) * _LENGTHS + 1, dtype=np.int64)
    classes = np.empty(len(crowds), dtype=np.int64)
    for k in range(len(crowds)):
        short = int(_LENGTHS * (1.0 - lengths[k] / longest))
        classes[k] = crowds[k] * _LENGTHS + min(max(short, 0), _LENGTHS - 1)
        starts[classes[k] + 1] += 1
    starts = np.cumsum(starts)
    order = np.empty(len(crowds), dtype=np.int64)
    for k in range(len(crowds)):
        order[starts[classes[k]]] = k
        starts[classes[k]] += 1
    return order
