"""Subpixel refinement of straight edges by edge profiles in the grey image."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, GreyImage, Masks
from stereo_landmark.core.least_squares import robust_step
from stereo_landmark.core.primitives.edge_profiles import BandPixels, fit_edge_profiles
from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    PIXEL_VARIANCE,
    direction_bin,
    interpolate_response,
    nearest_blur,
    response_table,
)

ITERATIONS_MAX = 5
"""Largest number of refinement iterations of an outline."""

STEP_TOLERANCE = 0.02
"""Refinement has converged when an iteration moves the outline by less [px]."""

INITIAL_BLUR = 0.7
"""Initial value of the blur [px]."""

_PROFILE_LENGTH = 6.0
_PROFILES_MIN = 6
# Shortest span to measure, without the margins at both ends [px].
_SPAN_MIN = 5.0
_BLUR_STEP_MAX = 0.5
# Model error of a straight, evenly blurred edge, which averaging does not reduce [px].
_MODEL_SIGMA = 0.005


@dataclass(frozen=True)
class RefinedLine:
    """A line in the image.

    Attributes:
        middle: point of the line where offset and direction are independent, shape (2,) [px].
        direction: unit vector along the line, shape (2,).
        variances: variances of the offset [px²] and of the direction [rad²], shape (2,).
        blur: standard deviation of the edge's blur [px].
        inlier_fraction: inlier fraction of the profiles.
    """

    middle: Floats
    direction: Floats
    variances: Floats
    blur: float
    inlier_fraction: float


class _RefinedLines(NamedTuple):
    """Arrays of the same values for several lines, and whether each refinement succeeded."""

    found: Masks
    middles: Floats
    directions: Floats
    variances: Floats
    blurs: Floats
    inlier_fraction: Floats


def refine_lines(image: GreyImage, ends: Floats, is_closed: bool = False) -> list[RefinedLine] | None:
    """Refine straight edges between two points each; None if the image does not show all of them.

    Args:
        image: grey image, shape (h, w).
        ends: first and last points, off by about a pixel at most, shape (n, 2, 2) [px].
        is_closed: whether the edges form a closed polygon with the inside on the right; then they are measured jointly
            up to the corners. Otherwise they are not measured near both points, where corners are rounded.
    """
    measured = _refine(image, ends, response_table(), is_closed)
    if not measured.found.all():
        return None
    columns = measured.middles, measured.directions, measured.variances
    numbers = measured.blurs.tolist(), measured.inlier_fraction.tolist()
    return [RefinedLine(*line) for line in zip(*columns, *numbers, strict=True)]


@njit(cache=True, error_model='numpy')
def band_core(blur: float) -> float:
    """Return the half-width of the band around an outline that the blurred edge itself covers [px]."""
    return min(1.0 + 2.2 * np.sqrt(blur**2 + PIXEL_VARIANCE), 6.0)


@njit(cache=True, error_model='numpy')
def band_width(blur: float) -> float:
    """Return the half-width of the band of pixels around an outline [px]."""
    return min(1.5 + 5.0 * np.sqrt(blur**2 + PIXEL_VARIANCE), 8.5)


@njit(cache=True, error_model='numpy')
def next_blur(blur: float, step: float) -> float:
    """Return the blur after a step, limited to the tabulated range [px]."""
    step = min(max(step, -_BLUR_STEP_MAX), _BLUR_STEP_MAX)
    return min(max(blur + step, BLURS[0]), BLURS[-1])


@njit(cache=True, error_model='numpy')
def _refine(image: GreyImage, ends: Floats, table: Floats, is_closed: bool) -> _RefinedLines:
    """Iterate the refinement of lines with end points of shape (n, 2, 2)."""
    n = len(ends)
    lines = _RefinedLines(
        np.zeros(n, np.bool_), np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2)), np.empty(n), np.empty(n)
    )
    current, numbers = ends.copy(), np.full(n, nearest_blur(INITIAL_BLUR))
    is_converged, adjacent_edges = np.zeros(n, np.bool_), np.empty((2, 3))
    for _ in range(ITERATIONS_MAX):
        for k in range(n):
            if is_converged[k]:
                continue
            if is_closed:
                _write_line_equation(current[k - 1], adjacent_edges[0])
                _write_line_equation(current[(k + 1) % n], adjacent_edges[1])
            previous = numbers[k]
            numbers[k], moved = _refine_once(
                image, current[k], previous, table, adjacent_edges[: 2 * is_closed], k, lines
            )
            lines.found[k] = numbers[k] >= 0
            if not lines.found[k]:
                return lines
            is_converged[k] = moved < STEP_TOLERANCE and numbers[k] == previous
    return lines


@njit(cache=True, error_model='numpy')
def _write_line_equation(ends: Floats, line: Floats) -> None:
    """Write the right normal of a line and its offset along the normal, shape (3,)."""
    dx, dy = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    length = np.sqrt(dx * dx + dy * dy)
    line[0], line[1] = -dy / length, dx / length
    line[2] = line[0] * ends[0, 0] + line[1] * ends[0, 1]


@njit(cache=True, error_model='numpy')
def _refine_once(
    image: GreyImage, line: Floats, blur_index: int, table: Floats, adjacent_edges: Floats, k: int, lines: _RefinedLines
) -> tuple[int, float]:
    """Refine a line, shape (2, 2), by one iteration and write the results of line k.

    Returns:
        table index of the next blur, -1 if there is no line, and the size of the step [px].
    """
    blur = BLURS[blur_index]
    dx, dy = line[1, 0] - line[0, 0], line[1, 1] - line[0, 1]
    length = np.sqrt(dx * dx + dy * dy)
    span = length if len(adjacent_edges) else length - 2.0 * min(band_core(blur), 0.3 * length)
    if not span >= _SPAN_MIN:
        return -1, 0.0
    dx, dy = dx / length, dy / length
    x, y = 0.5 * (line[0, 0] + line[1, 0]), 0.5 * (line[0, 1] + line[1, 1])
    count = max(_PROFILES_MIN, int(np.rint(span / _PROFILE_LENGTH)))
    pixels, positions = line_band(image, (x, y), (dx, dy), span, band_width(blur), count)
    for adjacent_edge in adjacent_edges:
        apply_adjacent_edge(
            adjacent_edge, (x, y), (dx, dy), table[blur_index], blur**2 + PIXEL_VARIANCE, pixels, positions
        )
    found = fit_edge_profiles(pixels, table[blur_index], count, band_core(blur), True)
    jacobian = np.ones((count, 2))
    for profile in range(count):
        jacobian[profile, 1] = ((profile + 0.5) / count - 0.5) * span
    fit = robust_step(jacobian, found.offsets, found.sigmas, np.zeros(2))
    if not fit.found:
        return -1, 0.0
    shift, rotation_shift = fit.step[0], 0.5 * length * fit.step[1]
    for e, move in ((0, shift - rotation_shift), (1, shift + rotation_shift)):
        line[e, 0] -= move * dy
        line[e, 1] += move * dx
    lines.blurs[k], lines.inlier_fraction[k] = next_blur(blur, found.blur_step), fit.inlier_fraction
    _write_decorrelated(line, fit.covariance, k, lines)
    return nearest_blur(lines.blurs[k]), max(abs(shift), abs(rotation_shift))


@njit(cache=True, error_model='numpy')
def _write_decorrelated(line: Floats, covariance: Floats, k: int, lines: _RefinedLines) -> None:
    # The fit correlates offset and direction at the midpoint; find the point where they are independent.
    dx, dy = line[1, 0] - line[0, 0], line[1, 1] - line[0, 1]
    length = np.sqrt(dx * dx + dy * dy)
    along = -covariance[0, 1] / covariance[1, 1]
    lines.directions[k, 0], lines.directions[k, 1] = dx / length, dy / length
    for c in range(2):
        lines.middles[k, c] = 0.5 * (line[0, c] + line[1, c]) + along * lines.directions[k, c]
    lines.variances[k, 0] = covariance[0, 0] - covariance[0, 1] ** 2 / covariance[1, 1] + _MODEL_SIGMA**2
    lines.variances[k, 1] = covariance[1, 1]


@njit(cache=True, error_model='numpy')
def apply_adjacent_edge(
    other: Floats,
    middle: tuple[float, float],
    direction: tuple[float, float],
    curves: Floats,
    variance: float,
    pixels: BandPixels,
    positions: Floats,
) -> None:
    """Model the effect of an adjacent edge on the pixels near a corner.

    The visible inside is the probability that two normal variables, with the correlation of the edge normals, are
    below their limits: their product plus the first term of the series in the correlation.

    Args:
        other: inward normal and offset of the adjacent edge, shape (3,).
        middle: midpoint of this edge [px].
        direction: unit vector along this edge.
        curves: edge response for the present blur, shape (directions, distances, 3).
        variance: variance of the blurred edge, pixel included [px²].
        pixels: pixels of this edge; updated in place.
        positions: positions of the pixels along this edge from its midpoint, shape (n,) [px].
    """
    dx, dy = direction
    correlation = dx * other[1] - dy * other[0]
    start_depth = other[0] * middle[0] + other[1] * middle[1] - other[2]
    slope_along, slope_across = other[0] * dx + other[1] * dy, other[1] * dx - other[0] * dy
    curve, response = curves[direction_bin(other[0], other[1])], np.empty(3)
    cutoff = 4.0 * np.sqrt(variance)
    for p in range(len(positions)):
        depth = start_depth + positions[p] * slope_along + pixels.distances[p] * slope_across
        if depth < cutoff:
            interpolate_response(curve, max(depth, -cutoff), response)
            pixels.visibility[p] *= response[0]
            pixels.corner_terms[p] += correlation * variance * response[1]


@njit(cache=True, error_model='numpy')
def line_band(
    image: GreyImage, middle: tuple[float, float], direction: tuple[float, float], span: float, width: float, count: int
) -> tuple[BandPixels, Floats]:
    """Return the pixels in a band along the middle part of a line, and their positions along it [px]."""
    height, columns = image.shape
    dx, dy = direction
    capacity = int((span + 3.0) * (2.0 * width + 3.0) * 1.5) + 16
    profiles, distances, values = np.empty(capacity, np.int32), np.empty(capacity), np.empty(capacity)
    positions = np.empty(capacity)
    extent_x = 0.5 * span * abs(dx) + width * abs(dy)
    extent_y = 0.5 * span * abs(dy) + width * abs(dx)
    n = 0
    for y in range(max(0, int(middle[1] - extent_y)), min(height, int(middle[1] + extent_y) + 2)):
        low, high = _row_interval(y - middle[1], dx, dy, span, width, extent_x)
        for x in range(max(0, int(middle[0] + low)), min(columns, int(middle[0] + high) + 2)):
            ex, ey = x - middle[0], y - middle[1]
            along, across = dx * ex + dy * ey, dx * ey - dy * ex
            if abs(across) > width or abs(along) >= 0.5 * span or n == capacity:
                continue
            profiles[n] = int((along / span + 0.5) * count)
            distances[n], values[n], positions[n] = across, image[y, x], along
            n += 1
    directions = np.full(n, direction_bin(-dy, dx), np.int32)
    return BandPixels(profiles[:n], distances[:n], directions, values[:n], np.ones(n), np.zeros(n)), positions[:n]


@njit(cache=True, error_model='numpy')
def _row_interval(ey: float, dx: float, dy: float, span: float, width: float, extent_x: float) -> tuple[float, float]:
    """Return the interval of x, from the middle, in which an image row crosses the band [px]."""
    low, high = -extent_x, extent_x
    if abs(dy) > 0.05:
        ends = (dx * ey - width) / dy, (dx * ey + width) / dy
        low, high = max(low, min(ends)), min(high, max(ends))
    if abs(dx) > 0.05:
        ends = (-0.5 * span - dy * ey) / dx, (0.5 * span - dy * ey) / dx
        low, high = max(low, min(ends)), min(high, max(ends))
    return low - 1.0, high
