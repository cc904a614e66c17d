"""Grey levels along the outline of a quadrilateral: the inside, the grain of the wall around it, and the noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.outline_band import Band

KNOTS = 8
BLUR, INSIDE, OUTSIDE = 8, 9, 12
UNKNOWNS = OUTSIDE + KNOTS
"""First come the corners; last the level inside, in the middle and how it changes along x and y, and those outside."""
FLAT = 0.02
"""Pixels that are covered by less than this, or all but this, show a level."""
_FLAT_MIN = 12
_AGREEING = 4.0
_SHADING = 0.03
"""Outside the core a pixel agrees within so many deviations of the noise and this part of the contrast."""
_LEVEL_APART = 0.01
"""Sides whose levels differ by more than this part of the contrast have levels of their own."""
_NOISE_MAX = 0.06
"""Where grey levels scatter by a larger part of the contrast, something else than noise may hide in it."""
_ROUNDING = 12.0**-0.5


class OutlineState(NamedTuple):
    """What is fitted.

    Attributes:
        blur: shape (1,) [px].
        noise: shape (2,), variance of the grey levels outside and inside.
        levels: shape (11,), in the order of the unknowns.
        corners: shape (4, 2) [px].
    """

    blur: NDArray[np.float64]
    noise: NDArray[np.float64]
    levels: NDArray[np.float64]
    corners: NDArray[np.float64]


@njit(cache=True, error_model='numpy')
def guess_levels(band: Band, core: NDArray[np.bool_], levels: NDArray[np.float64]) -> bool:
    """Write the levels that the pixels on both sides of the edge have on average."""
    outside, inside = band.values[core & (band.covered < 0.3)], band.values[core & (band.covered > 0.7)]
    if min(len(outside), len(inside)) < _FLAT_MIN:
        return False
    levels[0], levels[3:] = np.median(inside), np.median(outside)
    return levels[0] != levels[3]


@njit(cache=True, error_model='numpy')
def rests_of(band: Band, levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much pixels are brighter than the model says, shape (n,)."""
    rests = np.empty(len(band.values))
    for p in range(len(rests)):
        outside = _outside(band.places[p], levels)
        rests[p] = band.values[p] - outside - _contrast(band.places[p], levels) * band.covered[p]
    return rests


@njit(cache=True, error_model='numpy')
def _outside(place: NDArray[np.float64], levels: NDArray[np.float64]) -> float:
    knot = int(place[2])
    here, there = levels[3 + knot % KNOTS], levels[3 + (knot + 1) % KNOTS]
    return here + (place[2] - knot) * (there - here)


@njit(cache=True, error_model='numpy')
def _contrast(place: NDArray[np.float64], levels: NDArray[np.float64]) -> float:
    return levels[0] + levels[1] * place[0] + levels[2] * place[1] - _outside(place, levels)


@njit(cache=True, error_model='numpy')
def _typical_contrast(levels: NDArray[np.float64]) -> float:
    return abs(levels[0] - np.mean(levels[3:]))


@njit(cache=True, error_model='numpy')
def agreeing_pixels(band: Band, rests: NDArray[np.float64], state: OutlineState) -> NDArray[np.bool_]:
    """Return which pixels are as the model says, within noise and shading."""
    slack = _SHADING * _typical_contrast(state.levels)
    agreeing = np.empty(len(rests), np.bool_)
    for p in range(len(rests)):
        noise = np.sqrt(variance_of(band.covered[p], state.noise))
        agreeing[p] = abs(rests[p]) <= _AGREEING * noise + slack
    return agreeing


@njit(cache=True, error_model='numpy')
def variance_of(covered: float, noise: NDArray[np.float64]) -> float:
    """Return the variance of a pixel: light has noise that grows with it."""
    return noise[0] + (noise[1] - noise[0]) * covered if noise[0] < np.inf else np.inf


@njit(cache=True, error_model='numpy')
def measure_noise(
    band: Band, rests: NDArray[np.float64], used: NDArray[np.bool_], noise: NDArray[np.float64]
) -> bool:
    """Write the variances of the pixels that show a level."""
    for column, is_flat in ((0, band.covered < FLAT), (1, band.covered > 1.0 - FLAT)):
        flat = rests[used & is_flat]
        if len(flat) < _FLAT_MIN:
            return False
        noise[column] = max((1.4826 * np.median(np.abs(flat - np.median(flat)))) ** 2, _ROUNDING**2)
    return True


@njit(cache=True, error_model='numpy')
def write_row(band: Band, p: int, levels: NDArray[np.float64], row: NDArray[np.float64]) -> None:
    """Write how the unknowns change what a pixel shows."""
    place, covered = band.places[p], band.covered[p]
    contrast = _contrast(place, levels)
    for c in range(INSIDE):
        row[c] = contrast * band.changes[p, c]
    row[INSIDE], row[INSIDE + 1], row[INSIDE + 2] = covered, covered * place[0], covered * place[1]
    row[OUTSIDE:] = 0.0
    knot = int(place[2])
    row[OUTSIDE + knot % KNOTS] = (1.0 - covered) * (1.0 - place[2] + knot)
    row[OUTSIDE + (knot + 1) % KNOTS] = (1.0 - covered) * (place[2] - knot)


@njit(cache=True, error_model='numpy')
def levels_agree(
    band: Band, rests: NDArray[np.float64], used: NDArray[np.bool_], state: OutlineState, times: float
) -> bool:
    """Return whether the sides have the levels of the model, within so many times what may be."""
    contrast = _typical_contrast(state.levels)
    if np.sqrt(np.max(state.noise)) > times * _NOISE_MAX * contrast:
        return False
    slack = times * _LEVEL_APART * contrast
    sums, counts = np.zeros((4, 2)), np.zeros((4, 2))
    for p in range(len(rests)):
        inside = 1 if band.covered[p] > 0.5 else 0
        if used[p] and (band.covered[p] < FLAT or band.covered[p] > 1.0 - FLAT):
            sums[band.sides[p], inside] += rests[p]
            counts[band.sides[p], inside] += 1.0
    for k in range(4):
        for inside in range(2):
            n = max(counts[k, inside], 1.0)
            if abs(sums[k, inside]) / n > slack + 3.0 * times * np.sqrt(state.noise[inside] / n):
                return False
    return True
