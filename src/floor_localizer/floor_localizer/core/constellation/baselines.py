"""The baselines of a view, in the order in which their constellations are looked up."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.constellation_key import INNER_DOTS
from floor_localizer.core.constellation.lune import distance, dots_in_lune
from floor_localizer.core.constellation.view_dots import ViewDots

# Baselines with more dots in their lune are skipped: hardly any of their constellations would be complete and indexed.
VIEW_LUNE_DOTS_MAX = 12
# Number of length classes for baselines with equally many dots in their lunes.
_LENGTH_CLASSES = 8


class ViewBaselines(NamedTuple):
    """Baselines of a view, sorted by the number of dots in their lunes, then from long to short.

    Attributes:
        ends: shape (p, 2), dots at both ends.
        lengths: shape (p,), lengths [m].
        lune_counts: shape (p,), numbers of dots in the lunes.
    """

    ends: NDArray[np.int64]
    lengths: NDArray[np.float64]
    lune_counts: NDArray[np.int64]


@njit(cache=True)
def list_baselines(view: ViewDots, min_length: float, max_length: float) -> ViewBaselines:
    """List the baselines of a view with a length in a range [m] and enough dots for a constellation."""
    n, m = view.neighbours.shape
    baselines = ViewBaselines(
        np.empty((n * m, 2), dtype=np.int64), np.empty(n * m), np.empty(n * m, dtype=np.int64)
    )
    lune = np.empty(VIEW_LUNE_DOTS_MAX + 1, dtype=np.int64)
    count = 0
    for first in range(n):
        for second in view.neighbours[first, min(INNER_DOTS, m) :]:
            length = distance(view.points, first, second)
            if length > max_length:
                break
            if first > second or length < min_length:
                continue
            inside = dots_in_lune(
                view.points, first, second, view.neighbours[first], length + 2.0 * view.sigma, lune
            )
            if INNER_DOTS <= inside <= VIEW_LUNE_DOTS_MAX:
                baselines.ends[count, 0], baselines.ends[count, 1] = first, second
                baselines.lengths[count] = length
                baselines.lune_counts[count] = inside
                count += 1
    order = _sort_order(baselines.lune_counts[:count], baselines.lengths[:count], max_length)
    return ViewBaselines(baselines.ends[order], baselines.lengths[order], baselines.lune_counts[order])


@njit(cache=True)
def _sort_order(
    lune_counts: NDArray[np.int64], lengths: NDArray[np.float64], max_length: float
) -> NDArray[np.int64]:
    """Return the order by lune count, then from long to short in classes of length (a counting sort)."""
    starts = np.zeros((VIEW_LUNE_DOTS_MAX + 1) * _LENGTH_CLASSES + 1, dtype=np.int64)
    classes = np.empty(len(lune_counts), dtype=np.int64)
    for k in range(len(lune_counts)):
        length_class = int(_LENGTH_CLASSES * (1.0 - lengths[k] / max_length))
        classes[k] = lune_counts[k] * _LENGTH_CLASSES + min(max(length_class, 0), _LENGTH_CLASSES - 1)
        starts[classes[k] + 1] += 1
    starts = np.cumsum(starts)
    order = np.empty(len(lune_counts), dtype=np.int64)
    for k in range(len(lune_counts)):
        order[starts[classes[k]]] = k
        starts[classes[k]] += 1
    return order
