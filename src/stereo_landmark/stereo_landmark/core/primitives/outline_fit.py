"""A whole quadrilateral fitted to the grey image at once, its sides and the rounded places where they meet.

Side by side, each section with grey levels of its own, tells less: near a corner nothing is measured, and grey levels
that hardly change all around are learned again for each section. So all pixels along the outline are explained by one
blur, four corners, a level inside, which light may let change evenly over the image, and levels outside at the corners
and half-way between them, for walls have a grain. Where that does not explain them (shadows, things that hide a part,
another thing at a corner), there is no fit, and the sides measured alone stand.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.edge_response import BLURS, PIXEL_VARIANCE, nearest_blur
from stereo_landmark.core.primitives.outline_band import Band, band_along
from stereo_landmark.core.primitives.outline_model import (
    BLUR,
    FLAT,
    INSIDE,
    UNKNOWNS,
    OutlineState,
    agreeing_pixels,
    guess_levels,
    levels_agree,
    measure_noise,
    rests_of,
    variance_of,
    write_row,
)
from stereo_landmark.core.symmetric_matrix import invert_symmetric

ROUNDS = 7
SMALL_STEP = 0.003
"""A round that moves corners by less was the last one [px]."""
_WIDTH = 7.0
"""Half the width of the band in standard deviations of the edge."""
_CORE = 3.6
"""Nearer than this many all pixels count, farther ones only where they agree."""
_NARROW = 2.4
"""The same where there is another edge, as behind the narrow frame of an instrument."""
_ROUGHLY = 3.0
"""After the first step levels may differ and scatter by so many times more."""
_AGREEING_MIN = 0.95
_SCATTER_MAX = 4.0
_SIGMA_MAX = 0.5
"""A corner that is known worse is not known [px]."""
_MODEL_SIGMA = 0.005
"""No outline is as straight and evenly blurred as its model: what no number of pixels averages out [px]."""
_MOVED_MAX = 1.0
"""Corners that leave where the sides alone meet by more belong to something else [px]."""


class OutlineFit(NamedTuple):
    """A fitted quadrilateral.

    Attributes:
        found: whether the model explains the pixels; all else means nothing otherwise.
        corners: shape (4, 2) [px].
        covariance: shape (8, 8) [px²].
        agreeing: part of the pixels in the core that agree.
    """

    found: bool
    corners: NDArray[np.float64]
    covariance: NDArray[np.float64]
    agreeing: float


@njit(cache=True, error_model='numpy')
def fit_outline(
    image: NDArray[np.uint8], corners: NDArray[np.float64], blur: float, table: NDArray[np.float64]
) -> OutlineFit:
    """Fit a quadrilateral to the pixels along its outline.

    Args:
        image: shape (h, w), grey levels.
        corners: shape (4, 2), clockwise as seen in the image, some tenths of a pixel off at most [px].
        blur: about that of its sides [px].
        table: of `edge_response.response_table`.
    """
    fit = _fit(image, corners, blur, table, _CORE)
    return fit if fit.found else _fit(image, corners, blur, table, _NARROW)


@njit(cache=True, error_model='numpy')
def _fit(
    image: NDArray[np.uint8],
    corners: NDArray[np.float64],
    blur: float,
    table: NDArray[np.float64],
    inner: float,
) -> OutlineFit:
    """The same with the core of the band reaching inside so many deviations of the edge."""
    state = OutlineState(np.array([blur]), np.full(2, np.inf), np.zeros(UNKNOWNS - INSIDE), corners.copy())
    covariance = np.zeros((UNKNOWNS, UNKNOWNS))
    fit = OutlineFit(False, state.corners, np.eye(8), 0.0)
    for turn in range(ROUNDS):
        number = nearest_blur(state.blur[0])
        sigma = np.sqrt(BLURS[number] ** 2 + PIXEL_VARIANCE)
        outer = _WIDTH * sigma
        reach = -outer, outer if inner == _CORE else inner * sigma
        band = band_along(image, state.corners, table[number], sigma**2, reach)
        core = (band.depths > -_CORE * sigma) & (band.depths < inner * sigma)
        if turn == 0 and not guess_levels(band, core, state.levels):
            return fit
        rests = rests_of(band, state.levels)
        used = agreeing_pixels(band, rests, state) & (core | (turn > 1))
        if turn > 0 and not measure_noise(band, rests, used, state.noise):
            return fit
        # Most things that a picture shows are no evenly coloured plates, and the first round tells it.
        if turn == 1 and not (
            np.sum(core & used) >= _AGREEING_MIN * np.sum(core)
            and levels_agree(band, rests, core & used, state, _ROUGHLY)
        ):
            return fit
        step = _step(band, rests, used, state, covariance)
        state.blur[0] = min(max(BLURS[number] + step[BLUR], BLURS[0]), BLURS[-1])
        state.levels[:] += step[INSIDE:]
        state.corners[:] += step[:8].reshape(4, 2)
        if not np.max(np.abs(state.corners - corners)) < _MOVED_MAX:
            return fit
        if turn > 2 and np.max(np.abs(step[:8])) < SMALL_STEP:
            return _judged(band, core, rests, used, state, covariance)
    return fit


@njit(cache=True, error_model='numpy')
def _step(
    band: Band,
    rests: NDArray[np.float64],
    used: NDArray[np.bool_],
    state: OutlineState,
    covariance: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return what is to be added to the unknowns; not a number where pixels do not tell them."""
    information, pull = np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS)
    _sum_up(band, rests, used, state, information, pull)
    for i in range(UNKNOWNS):
        for j in range(i):
            information[j, i] = information[i, j]
    if not invert_symmetric(information, covariance):
        return np.full(UNKNOWNS, np.nan)
    step = np.zeros(UNKNOWNS)
    for i in range(UNKNOWNS):
        for j in range(UNKNOWNS):
            step[i] += covariance[i, j] * pull[j]
    return step


@njit(cache=True, error_model='numpy')
def _sum_up(
    band: Band,
    rests: NDArray[np.float64],
    used: NDArray[np.bool_],
    state: OutlineState,
    information: NDArray[np.float64],
    pull: NDArray[np.float64],
) -> None:
    """Add the pixels to the lower half of the normal equations."""
    row, told = np.empty(UNKNOWNS), np.empty(UNKNOWNS, np.int64)
    for p in np.flatnonzero(used):
        write_row(band, p, state.levels, row)
        variance = variance_of(band.covered[p], state.noise)
        weight = 1.0 / variance if variance < np.inf else 1.0
        count = 0
        # Most pixels tell of one side only.
        for i in range(UNKNOWNS):
            if row[i] != 0.0:
                told[count] = i
                count += 1
        for a in range(count):
            part = weight * row[told[a]]
            pull[told[a]] += part * rests[p]
            for b in range(a + 1):
                information[told[a], told[b]] += part * row[told[b]]


@njit(cache=True, error_model='numpy')
def _judged(
    band: Band,
    core: NDArray[np.bool_],
    rests: NDArray[np.float64],
    used: NDArray[np.bool_],
    state: OutlineState,
    covariance: NDArray[np.float64],
) -> OutlineFit:
    """Return the fit, not found where the pixels say that the model is another."""
    scatter, edge = 0.0, 0
    for p in range(len(rests)):
        if used[p] and FLAT < band.covered[p] < 1.0 - FLAT:
            scatter += rests[p] ** 2 / variance_of(band.covered[p], state.noise)
            edge += 1
    scatter = max(scatter / max(edge - UNKNOWNS, 1), 1.0)
    agreeing = np.sum(core & used) / max(np.sum(core), 1)
    corners = covariance[:8, :8] * scatter + _MODEL_SIGMA**2 * np.eye(8)
    found = (
        agreeing >= _AGREEING_MIN
        and scatter <= _SCATTER_MAX
        and np.max(np.diag(corners)) < _SIGMA_MAX**2
        and levels_agree(band, rests, core & used, state, 1.0)
    )
    return OutlineFit(found, state.corners, corners, agreeing)
