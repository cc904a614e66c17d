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

from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    PIXEL_VARIANCE,
    direction_bin,
    look_up,
    nearest_blur,
)
from stereo_landmark.core.symmetric_matrix import invert_symmetric

ROUNDS = 7
SMALL_STEP = 0.003
"""A round that moves corners by less was the last one [px]."""
_KNOTS = 8
_BLUR, _INSIDE, _OUTSIDE = 8, 9, 12
_UNKNOWNS = _OUTSIDE + _KNOTS
"""First come the corners; last the level inside, in the middle and how it changes along x and y, and those outside."""
_WIDTH = 7.0
"""Half the width of the band in standard deviations of the edge."""
_CORE = 3.6
"""Nearer than this many all pixels count, farther ones only where they agree."""
_NARROW = 2.4
"""The same where there is another edge, as behind the narrow frame of an instrument."""
_FLAT = 0.02
"""Pixels that are covered by less than this, or all but this, show a level."""
_FLAT_MIN = 12
_AGREEING = 4.0
_SHADING = 0.03
"""Outside the core a pixel agrees within so many deviations of the noise and this part of the contrast."""
_LEVEL_APART = 0.01
"""Sides whose levels differ by more than this part of the contrast have levels of their own."""
_ROUGHLY = 3.0
"""After the first step levels may differ by so many times more."""
_AGREEING_MIN = 0.95
_SCATTER_MAX = 4.0
_SIGMA_MAX = 0.5
"""A corner that is known worse is not known [px]."""
_MODEL_SIGMA = 0.005
"""No outline is as straight and evenly blurred as its model: what no number of pixels averages out [px]."""
_MOVED_MAX = 1.0
"""Corners that leave where the sides alone meet by more belong to something else [px]."""
_ROUNDING = 12.0**-0.5


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


class _Band(NamedTuple):
    """The n pixels along an outline.

    Attributes:
        values: shape (n,) [grey levels].
        covered: shape (n,), by how much the quadrilateral covers each, as it is seen.
        depths: shape (n,), how far inside of the nearest side [px].
        sides: shape (n,), the nearest one.
        places: shape (n, 3), from the middle along x and y, as parts of the size, and along the outline, 2 a side.
        changes: shape (n, 9), of the coverage by the corners' coordinates and the blur.
    """

    values: NDArray[np.float64]
    covered: NDArray[np.float64]
    depths: NDArray[np.float64]
    sides: NDArray[np.int64]
    places: NDArray[np.float64]
    changes: NDArray[np.float64]


class _State(NamedTuple):
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
    state = _State(np.array([blur]), np.full(2, np.inf), np.zeros(_UNKNOWNS - _INSIDE), corners.copy())
    covariance = np.zeros((_UNKNOWNS, _UNKNOWNS))
    fit = OutlineFit(False, state.corners, np.eye(8), 0.0)
    for turn in range(ROUNDS):
        number = nearest_blur(state.blur[0])
        sigma = np.sqrt(BLURS[number] ** 2 + PIXEL_VARIANCE)
        outer = _WIDTH * sigma
        reach = -outer, outer if inner == _CORE else inner * sigma
        band = _band(image, state.corners, table[number], sigma**2, reach)
        core = (band.depths > -_CORE * sigma) & (band.depths < inner * sigma)
        if turn == 0 and not _guess_levels(band, core, state.levels):
            return fit
        rests = _rests(band, state.levels)
        used = _agreeing(band, rests, state) & (core | (turn > 1))
        if turn > 0 and not _measure_noise(band, rests, used, state.noise):
            return fit
        # Most things that a picture shows are no evenly coloured plates, and the first round tells it.
        if turn == 1 and not (
            np.sum(core & used) >= _AGREEING_MIN * np.sum(core)
            and _levels_agree(band, rests, core & used, state, _ROUGHLY)
        ):
            return fit
        step = _step(band, rests, used, state, covariance)
        state.blur[0] = min(max(BLURS[number] + step[_BLUR], BLURS[0]), BLURS[-1])
        state.levels[:] += step[_INSIDE:]
        state.corners[:] += step[:8].reshape(4, 2)
        if not np.max(np.abs(state.corners - corners)) < _MOVED_MAX:
            return fit
        if turn > 2 and np.max(np.abs(step[:8])) < SMALL_STEP:
            return _judged(band, core, rests, used, state, covariance)
    return fit


@njit(cache=True, error_model='numpy')
def _guess_levels(band: _Band, core: NDArray[np.bool_], levels: NDArray[np.float64]) -> bool:
    """Write the levels that the pixels on both sides of the edge have on average."""
    outside, inside = band.values[core & (band.covered < 0.3)], band.values[core & (band.covered > 0.7)]
    if min(len(outside), len(inside)) < _FLAT_MIN:
        return False
    levels[0], levels[3:] = np.median(inside), np.median(outside)
    return levels[0] != levels[3]


@njit(cache=True, error_model='numpy')
def _rests(band: _Band, levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much pixels are brighter than the model says, shape (n,)."""
    rests = np.empty(len(band.values))
    for p in range(len(rests)):
        outside = _outside(band.places[p], levels)
        rests[p] = band.values[p] - outside - _contrast(band.places[p], levels) * band.covered[p]
    return rests


@njit(cache=True, error_model='numpy')
def _outside(place: NDArray[np.float64], levels: NDArray[np.float64]) -> float:
    knot = int(place[2])
    here, there = levels[3 + knot % _KNOTS], levels[3 + (knot + 1) % _KNOTS]
    return here + (place[2] - knot) * (there - here)


@njit(cache=True, error_model='numpy')
def _contrast(place: NDArray[np.float64], levels: NDArray[np.float64]) -> float:
    return levels[0] + levels[1] * place[0] + levels[2] * place[1] - _outside(place, levels)


@njit(cache=True, error_model='numpy')
def _typical_contrast(levels: NDArray[np.float64]) -> float:
    return abs(levels[0] - np.mean(levels[3:]))


@njit(cache=True, error_model='numpy')
def _agreeing(band: _Band, rests: NDArray[np.float64], state: _State) -> NDArray[np.bool_]:
    """Return which pixels are as the model says, within noise and shading."""
    slack = _SHADING * _typical_contrast(state.levels)
    agreeing = np.empty(len(rests), np.bool_)
    for p in range(len(rests)):
        noise = np.sqrt(_variance(band.covered[p], state.noise))
        agreeing[p] = abs(rests[p]) <= _AGREEING * noise + slack
    return agreeing


@njit(cache=True, error_model='numpy')
def _variance(covered: float, noise: NDArray[np.float64]) -> float:
    """Return the variance of a pixel: light has noise that grows with it."""
    return noise[0] + (noise[1] - noise[0]) * covered if noise[0] < np.inf else np.inf


@njit(cache=True, error_model='numpy')
def _measure_noise(
    band: _Band, rests: NDArray[np.float64], used: NDArray[np.bool_], noise: NDArray[np.float64]
) -> bool:
    """Write the variances of the pixels that show a level."""
    for column, is_flat in ((0, band.covered < _FLAT), (1, band.covered > 1.0 - _FLAT)):
        flat = rests[used & is_flat]
        if len(flat) < _FLAT_MIN:
            return False
        noise[column] = max((1.4826 * np.median(np.abs(flat - np.median(flat)))) ** 2, _ROUNDING**2)
    return True


@njit(cache=True, error_model='numpy')
def _step(
    band: _Band,
    rests: NDArray[np.float64],
    used: NDArray[np.bool_],
    state: _State,
    covariance: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return what is to be added to the unknowns; not a number where pixels do not tell them."""
    information = np.zeros((_UNKNOWNS, _UNKNOWNS))
    row, pull, step = np.empty(_UNKNOWNS), np.zeros(_UNKNOWNS), np.zeros(_UNKNOWNS)
    told = np.empty(_UNKNOWNS, np.int64)
    for p in range(len(rests)):
        if not used[p]:
            continue
        _write_row(band, p, state.levels, row)
        variance = _variance(band.covered[p], state.noise)
        weight = 1.0 / variance if variance < np.inf else 1.0
        count = 0
        # Most pixels tell of one side only.
        for i in range(_UNKNOWNS):
            if row[i] != 0.0:
                told[count] = i
                count += 1
        for a in range(count):
            part = weight * row[told[a]]
            pull[told[a]] += part * rests[p]
            for b in range(a + 1):
                information[told[a], told[b]] += part * row[told[b]]
    for i in range(_UNKNOWNS):
        for j in range(i):
            information[j, i] = information[i, j]
    if not invert_symmetric(information, covariance):
        return np.full(_UNKNOWNS, np.nan)
    for i in range(_UNKNOWNS):
        for j in range(_UNKNOWNS):
            step[i] += covariance[i, j] * pull[j]
    return step


@njit(cache=True, error_model='numpy')
def _write_row(band: _Band, p: int, levels: NDArray[np.float64], row: NDArray[np.float64]) -> None:
    """Write how the unknowns change what a pixel shows."""
    place, covered = band.places[p], band.covered[p]
    contrast = _contrast(place, levels)
    for c in range(_INSIDE):
        row[c] = contrast * band.changes[p, c]
    row[_INSIDE], row[_INSIDE + 1], row[_INSIDE + 2] = covered, covered * place[0], covered * place[1]
    row[_OUTSIDE:] = 0.0
    knot = int(place[2])
    row[_OUTSIDE + knot % _KNOTS] = (1.0 - covered) * (1.0 - place[2] + knot)
    row[_OUTSIDE + (knot + 1) % _KNOTS] = (1.0 - covered) * (place[2] - knot)


@njit(cache=True, error_model='numpy')
def _judged(
    band: _Band,
    core: NDArray[np.bool_],
    rests: NDArray[np.float64],
    used: NDArray[np.bool_],
    state: _State,
    covariance: NDArray[np.float64],
) -> OutlineFit:
    """Return the fit, not found where the pixels say that the model is another."""
    scatter, edge = 0.0, 0
    for p in range(len(rests)):
        if used[p] and _FLAT < band.covered[p] < 1.0 - _FLAT:
            scatter += rests[p] ** 2 / _variance(band.covered[p], state.noise)
            edge += 1
    scatter = max(scatter / max(edge - _UNKNOWNS, 1), 1.0)
    agreeing = np.sum(core & used) / max(np.sum(core), 1)
    corners = covariance[:8, :8] * scatter + _MODEL_SIGMA**2 * np.eye(8)
    found = (
        agreeing >= _AGREEING_MIN
        and scatter <= _SCATTER_MAX
        and np.max(np.diag(corners)) < _SIGMA_MAX**2
        and _levels_agree(band, rests, core & used, state, 1.0)
    )
    return OutlineFit(found, state.corners, corners, agreeing)


@njit(cache=True, error_model='numpy')
def _levels_agree(
    band: _Band, rests: NDArray[np.float64], used: NDArray[np.bool_], state: _State, times: float
) -> bool:
    """Return whether the sides have the levels of the model, within so many times what may be."""
    slack = times * _LEVEL_APART * _typical_contrast(state.levels)
    sums, counts = np.zeros((4, 2)), np.zeros((4, 2))
    for p in range(len(rests)):
        inside = 1 if band.covered[p] > 0.5 else 0
        if used[p] and (band.covered[p] < _FLAT or band.covered[p] > 1.0 - _FLAT):
            sums[band.sides[p], inside] += rests[p]
            counts[band.sides[p], inside] += 1.0
    for k in range(4):
        for inside in range(2):
            n = max(counts[k, inside], 1.0)
            if abs(sums[k, inside]) / n > slack + 3.0 * times * np.sqrt(state.noise[inside] / n):
                return False
    return True


@njit(cache=True, error_model='numpy')
def _band(
    image: NDArray[np.uint8],
    corners: NDArray[np.float64],
    profiles: NDArray[np.float64],
    variance: float,
    reach: tuple[float, float],
) -> _Band:
    """Return the pixels from so far outside (negative) to so far inside of the nearest side [px].

    The profiles are those of an edge of some variance [px²].
    """
    height, width = image.shape
    lines, bins = _lines(corners)
    left, right = max(0, int(np.min(corners[:, 0]) + reach[0])), int(np.max(corners[:, 0]) - reach[0]) + 1
    top, bottom = max(0, int(np.min(corners[:, 1]) + reach[0])), int(np.max(corners[:, 1]) - reach[0]) + 1
    right, bottom = min(right, width - 1), min(bottom, height - 1)
    room = min((right - left + 1) * (bottom - top + 1), int(2.0 * (reach[1] - reach[0]) * np.sum(lines[:, 4])))
    room = max(room, 0) + 64
    band = _Band(
        np.empty(room), np.empty(room), np.empty(room), np.empty(room, np.int64), np.empty((room, 3)), np.empty((room, 9))
    )
    middle, size = 0.25 * np.sum(corners, axis=0), 0.25 * np.sum(lines[:, 4])
    responses, distances = np.empty((4, 3)), np.empty(4)
    n = 0
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            nearest = 0
            for k in range(4):
                distances[k] = lines[k, 0] * x + lines[k, 1] * y - lines[k, 2]
                if distances[k] < distances[nearest]:
                    nearest = k
            depth = distances[nearest]
            if depth < reach[0] or depth > reach[1] or n == room:
                continue
            for k in range(4):
                look_up(profiles[bins[k]], distances[k], responses[k])
            band.values[n], band.depths[n], band.sides[n] = image[y, x], depth, nearest
            band.places[n, 0], band.places[n, 1] = (x - middle[0]) / size, (y - middle[1]) / size
            along = (lines[nearest, 1] * x - lines[nearest, 0] * y - lines[nearest, 3]) / lines[nearest, 4]
            band.places[n, 2] = 2.0 * (nearest + min(max(along, 0.0), 1.0))
            band.covered[n] = _write_changes(x, y, lines, responses, band.changes[n])
            band.covered[n] += _by_skew(lines, responses, variance)
            n += 1
    first = band.values[:n], band.covered[:n], band.depths[:n], band.sides[:n]
    return _Band(*first, band.places[:n], band.changes[:n])


@njit(cache=True, error_model='numpy')
def _lines(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return normal to the inside, its offset, offset of the begin along the line, and length of each side, (4, 5).

    And the bins of their directions, shape (4,).
    """
    lines, bins = np.empty((4, 5)), np.empty(4, np.int64)
    for k in range(4):
        dx, dy = corners[(k + 1) % 4] - corners[k]
        length = np.sqrt(dx * dx + dy * dy)
        dx, dy = dx / length, dy / length
        lines[k, 0], lines[k, 1] = -dy, dx
        lines[k, 2] = -dy * corners[k, 0] + dx * corners[k, 1]
        lines[k, 3], lines[k, 4] = dx * corners[k, 0] + dy * corners[k, 1], length
        bins[k] = direction_bin(-dy, dx)
    return lines, bins


@njit(cache=True, error_model='numpy')
def _write_changes(
    x: float,
    y: float,
    lines: NDArray[np.float64],
    responses: NDArray[np.float64],
    changes: NDArray[np.float64],
) -> float:
    """Write how corners and blur change the coverage of a pixel, and return it."""
    covered = responses[0, 0] * responses[1, 0] * responses[2, 0] * responses[3, 0]
    changes[:] = 0.0
    for k in range(4):
        after = (k + 1) % 4
        others = responses[after, 0] * responses[(k + 2) % 4, 0] * responses[(k + 3) % 4, 0]
        slope = others * responses[k, 1]
        changes[8] += others * responses[k, 2]
        along = (lines[k, 1] * x - lines[k, 0] * y - lines[k, 3]) / lines[k, 4]
        for c in range(2):
            changes[2 * k + c] -= slope * (1.0 - along) * lines[k, c]
            changes[2 * after + c] -= slope * along * lines[k, c]
    return covered


@njit(cache=True, error_model='numpy')
def _by_skew(lines: NDArray[np.float64], responses: NDArray[np.float64], variance: float) -> float:
    """Return what the coverage is more than the product of the sides where these meet at no right angle.

    The coverage at a corner is the probability that two correlated normal deviates are both below their limits; this is
    the first term of its series by the correlation, which is that of the sides' normals.
    """
    more = 0.0
    for k in range(4):
        after = (k + 1) % 4
        correlation = lines[k, 0] * lines[after, 0] + lines[k, 1] * lines[after, 1]
        others = responses[(k + 2) % 4, 0] * responses[(k + 3) % 4, 0]
        more += correlation * variance * responses[k, 1] * responses[after, 1] * others
    return more
