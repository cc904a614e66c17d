"""Constellations of six dots and their keys, step by step."""

import numpy as np

from floor_localizer.core.constellation.constellation_key import (
    INNER_DOTS,
    KEY_SIZE,
    baseline_coordinates,
    mean_x_offset,
    quantize_coordinates,
    sort_by_x,
    swap_ends,
)


def six_dots(rng):
    return np.vstack([[[0.0, 0.0], [1.0, 0.0]], rng.uniform((0.1, -0.5), (0.9, 0.5), (INNER_DOTS, 2))])


def coordinates(points, first=0, second=1, *others):
    xy = np.empty((INNER_DOTS, 2))
    baseline_coordinates(points, first, second, np.array(others or range(2, 6)), xy)
    return xy


def steps_of(xy, step):
    steps = np.empty(KEY_SIZE, dtype=np.int64)
    quantize_coordinates(xy, step, steps)
    return steps


def canonical_key(points, step, *dots):
    """The steps of the key in canonical order, its coordinates, and whether the ends were swapped."""
    xy = coordinates(points, *dots)
    is_swapped = mean_x_offset(xy) > 0.0
    if is_swapped:
        swap_ends(xy)
    sort_by_x(xy)
    return steps_of(xy, step), xy, is_swapped
