"""A straight side, measured in the grey image."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    PIXEL_VARIANCE,
    direction_bin,
    nearest_blur,
    response_table,
)
from stereo_landmark.core.primitives.edge_sections import BandPixels, measure_sections
from stereo_landmark.core.primitives.robust_step import robust_step

ROUNDS = 5
"""How often an outline is measured at most: each round starts where the last one ended."""

SMALL_STEP = 0.02
"""A round that moves an outline by less was the last one [px]."""

FIRST_BLUR = 0.7
"""What is supposed of the blur at first [px]."""

_SECTION = 6.0
_SECTIONS_MIN = 6
# The shortest part of a side that is measured, margins at both ends taken off [px].
_SPAN_MIN = 5.0
_BLUR_STEP_MAX = 0.5
# No edge is as straight and evenly blurred as its model: what no number of pixels averages out [px].
_MODEL_SIGMA = 0.005


@dataclass(frozen=True)
class RefinedLine:
    """A line in the image.

    Attributes:
        middle: shape (2,), a point on it where offset and direction are independent [px].
        direction: shape (2,), unit vector.
        variances: shape (2,), of the offset [px²] and of the direction [rad²].
        blur: standard deviation of the edge's blur [px].
        agreeing: part of its length that agrees.
    """

    middle: NDArray[np.float64]
    direction: NDArray[np.float64]
    variances: NDArray[np.float64]
    blur: float
    agreeing: float


def band_core(blur: float) -> float:
    """Return how far from an outline pixels show nothing but its edge, as long as nothing else is near [px]."""
    return min(1.0 + 2.2 * math.sqrt(blur**2 + PIXEL_VARIANCE), 6.0)


def band_width(blur: float) -> float:
    """Return how far from an outline its pixels are looked at [px]."""
    return min(1.5 + 5.0 * math.sqrt(blur**2 + PIXEL_VARIANCE), 8.5)


def next_blur(blur: float, step: float) -> float:
    """Return the blur after a measured step, within what is tabulated [px]."""
    step = min(max(step, -_BLUR_STEP_MAX), _BLUR_STEP_MAX)
    return float(min(max(blur + step, BLURS[0]), BLURS[-1]))


def refine_line(
    image: NDArray[np.uint8], begin: NDArray[np.float64], end: NDArray[np.float64]
) -> RefinedLine | None:
    """Measure the edge between two points across itself.

    Args:
        image: shape (h, w), grey levels.
        begin: shape (2,), first point, at most about a pixel off [px].
        end: shape (2,), last point; near both points, where corners are round, nothing is measured [px].

    Returns:
        the line, None where the image shows no straight edge there.
    """
    blur = FIRST_BLUR
    line = None
    for _ in range(ROUNDS):
        chord = end - begin
        length = float(np.hypot(*chord))
        margin = min(band_core(blur), 0.3 * length)
        span = length - 2.0 * margin
        if span < _SPAN_MIN:
            return None
        direction, middle = chord / length, 0.5 * (begin + end)
        count = max(_SECTIONS_MIN, round(span / _SECTION))
        number = nearest_blur(blur)
        pixels = _line_band(image, middle, direction, span, band_width(blur), count)
        found = measure_sections(pixels, response_table()[number], count, band_core(blur))
        along = (np.arange(count) + 0.5) / count * span - 0.5 * span
        fit = robust_step(np.column_stack([np.ones(count), along]), found.offsets, found.sigmas, np.zeros(2))
        if not fit.found:
            return None
        shift, turn = fit.step
        normal = np.array([-direction[1], direction[0]])
        begin = begin + (shift - 0.5 * length * turn) * normal
        end = end + (shift + 0.5 * length * turn) * normal
        blur = next_blur(float(BLURS[number]), found.blur_step)
        line = _independent(begin, end, fit.covariance, blur, fit.agreeing)
        if max(abs(shift), 0.5 * length * abs(turn)) < SMALL_STEP and nearest_blur(blur) == number:
            break
    return line


def _independent(
    begin: NDArray[np.float64],
    end: NDArray[np.float64],
    covariance: NDArray[np.float64],
    blur: float,
    agreeing: float,
) -> RefinedLine:
    # Offset and turn are known together about the chord's middle; about another point they are independent.
    direction = (end - begin) / np.hypot(*(end - begin))
    along = -covariance[0, 1] / covariance[1, 1]
    offset = covariance[0, 0] - covariance[0, 1] ** 2 / covariance[1, 1] + _MODEL_SIGMA**2
    middle = 0.5 * (begin + end) + along * direction
    return RefinedLine(middle, direction, np.array([offset, covariance[1, 1]]), blur, agreeing)


@njit(cache=True, error_model='numpy')
def _line_band(
    image: NDArray[np.uint8],
    middle: NDArray[np.float64],
    direction: NDArray[np.float64],
    span: float,
    width: float,
    count: int,
) -> BandPixels:
    """Return the pixels up to a distance beside the middle part of a line."""
    height, columns = image.shape
    dx, dy = direction
    room = int((span + 3.0) * (2.0 * width + 3.0) * 1.5) + 16
    sections, distances, values = np.empty(room, np.int32), np.empty(room), np.empty(room)
    reach_x = 0.5 * span * abs(dx) + width * abs(dy)
    reach_y = 0.5 * span * abs(dy) + width * abs(dx)
    n = 0
    for y in range(max(0, int(middle[1] - reach_y)), min(height, int(middle[1] + reach_y) + 2)):
        low, high = _row_reach(y - middle[1], dx, dy, span, width, reach_x)
        for x in range(max(0, int(middle[0] + low)), min(columns, int(middle[0] + high) + 2)):
            ex, ey = x - middle[0], y - middle[1]
            along, across = dx * ex + dy * ey, dx * ey - dy * ex
            if abs(across) > width or abs(along) >= 0.5 * span or n == room:
                continue
            sections[n] = int((along / span + 0.5) * count)
            distances[n], values[n] = across, image[y, x]
            n += 1
    directions = np.full(n, direction_bin(-dy, dx), np.int32)
    return BandPixels(sections[:n], distances[:n], directions, values[:n])


@njit(cache=True, error_model='numpy')
def _row_reach(
    ey: float, dx: float, dy: float, span: float, width: float, reach_x: float
) -> tuple[float, float]:
    """Return between which x, from the middle, a row crosses the band [px]."""
    low, high = -reach_x, reach_x
    if abs(dy) > 0.05:
        ends = (dx * ey - width) / dy, (dx * ey + width) / dy
        low, high = max(low, min(ends)), min(high, max(ends))
    if abs(dx) > 0.05:
        ends = (-0.5 * span - dy * ey) / dx, (0.5 * span - dy * ey) / dx
        low, high = max(low, min(ends)), min(high, max(ends))
    return low - 1.0, high
