"""How much of each pixel around a blob the dot covers: its difference from the floor over the dot's own."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Field = NDArray[np.float32]
Vector = NDArray[np.float64]
Places = NDArray[np.int64]

# The floor's level: the mean of the ring's pixels within so many deviations of the median. A few of them tell the
# median, and the distance of the nearer sextile is about the deviation: what lies on a ring is on one side.
_FEW = 25
_INLIER_DEVIATIONS = 3.0
# The dot's level: the mean of its upper quarter, as a small dot has few pixels that it covers wholly.
_BINS = 64
_UPPER_SHARE = 0.25


@njit(cache=True, error_model='numpy')
def direction_of(image: Image, background: Field, places: Places) -> Vector:
    """Return the unit vector of the mean difference of some pixels from the floor, over the channels.

    Args:
        image: shape (h, w, channels), grey levels.
        background: shape (h, w, channels), grey levels of the floor.
        places: shape (n, 2), rows and columns.
    """
    direction = np.zeros(image.shape[2])
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        for c in range(image.shape[2]):
            direction[c] += image[v, u, c] / background[v, u, c] - 1.0
    return direction / max(np.sqrt(np.sum(direction**2)), 1e-12)


@njit(cache=True, error_model='numpy')
def differences_along(image: Image, background: Field, places: Places, direction: Vector) -> Vector:
    """Return the differences of pixels, shape (n,), from the floor along a direction, relative to the floor."""
    result = np.zeros(len(places))
    for k in range(len(places)):
        v, u = places[k, 0], places[k, 1]
        for c in range(image.shape[2]):
            result[k] += direction[c] * (image[v, u, c] / background[v, u, c] - 1.0)
    return result


@njit(cache=True, error_model='numpy')
def floor_level(ring: Vector) -> float:
    """Return the mean of a ring's differences, shape (n,), without those of what lies on it; 0 for no ring."""
    if len(ring) == 0:
        return 0.0
    few = _sorted_few(ring)
    middle = few[len(few) // 2]
    below, above = middle - few[len(few) // 6], few[(5 * len(few)) // 6] - middle
    reach = _INLIER_DEVIATIONS * min(below, above)
    total, count = 0.0, 0
    for value in ring:
        if abs(value - middle) <= reach:
            total += value
            count += 1
    return total / count


@njit(cache=True, error_model='numpy')
def _sorted_few(values: Vector) -> Vector:
    step = -(-len(values) // _FEW)
    few = values[::step].copy()
    for k in range(1, len(few)):
        value, place = few[k], k
        while place > 0 and few[place - 1] > value:
            few[place] = few[place - 1]
            place -= 1
        few[place] = value
    return few


@njit(cache=True, error_model='numpy')
def dot_level(inside: Vector) -> float:
    """Return the mean of the upper quarter of the differences of a blob's own pixels, shape (n,)."""
    top = np.max(inside)
    if top <= 0.0:
        return 0.0
    counts, sums = np.zeros(_BINS, np.int64), np.zeros(_BINS)
    for value in inside:
        place = min(_BINS - 1, int(max(0.0, value) / top * _BINS))
        counts[place] += 1
        sums[place] += value
    wanted = max(1.0, _UPPER_SHARE * len(inside))
    count, total = 0.0, 0.0
    for place in range(_BINS - 1, -1, -1):
        if counts[place] > 0:
            part = min(1.0, (wanted - count) / counts[place])
            count += part * counts[place]
            total += part * sums[place]
        if count >= wanted:
            break
    return total / count
