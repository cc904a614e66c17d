"""Subpixel refinement of straight edges by edge profiles in the grey image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.least_squares import robust_step
from stereo_landmark.core.primitives.edge_profiles import fit_edge_profiles
from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    PIXEL_VARIANCE,
    nearest_blur,
    response_table,
)
from stereo_landmark.core.primitives.line_band import apply_adjacent_edge, line_band

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

    middle: NDArray[np.float64]
    direction: NDArray[np.float64]
    variances: NDArray[np.float64]
    blur: float
    inlier_fraction: float


class _RefinedLines(NamedTuple):
    """Arrays of the same values for several lines, and whether each refinement succeeded."""

    found: NDArray[np.bool_]
    middles: NDArray[np.float64]
    directions: NDArray[np.float64]
    variances: NDArray[np.float64]
    blurs: NDArray[np.float64]
    inlier_fraction: NDArray[np.float64]


def refine_line(
    image: NDArray[np.uint8], begin: NDArray[np.float64], end: NDArray[np.float64]
) -> RefinedLine | None:
    """Refine the edge between two points.

    Args:
        image: grey image, shape (h, w).
        begin: first point, off by about a pixel at most, shape (2,) [px].
        end: last point, shape (2,) [px]; the edge is not measured near both points, where corners are rounded.

    Returns:
        refined line, None if the image does not show a straight edge there.
    """
    lines = refine_lines(image, np.array([[begin, end]]))
    return None if lines is None else lines[0]


def refine_lines(
    image: NDArray[np.uint8], ends: NDArray[np.float64], is_closed: bool = False
) -> list[RefinedLine] | None:
    """Refine several edges as `refine_line` does; None if the image does not show all of them.

    Args:
        image: grey image, shape (h, w).
        ends: first and last points, shape (n, 2, 2) [px].
        is_closed: whether the edges form a closed polygon with the inside on the right; then they are measured jointly
            up to the corners.
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
def _refine(
    image: NDArray[np.uint8], ends: NDArray[np.float64], table: NDArray[np.float64], is_closed: bool
) -> _RefinedLines:
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
def _write_line_equation(ends: NDArray[np.float64], line: NDArray[np.float64]) -> None:
    """Write the right normal of a line and its offset along the normal, shape (3,)."""
    dx, dy = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
    length = np.sqrt(dx * dx + dy * dy)
    line[0], line[1] = -dy / length, dx / length
    line[2] = line[0] * ends[0, 0] + line[1] * ends[0, 1]


@njit(cache=True, error_model='numpy')
def _refine_once(
    image: NDArray[np.uint8],
    line: NDArray[np.float64],
    blur_index: int,
    table: NDArray[np.float64],
    adjacent_edges: NDArray[np.float64],
    k: int,
    lines: _RefinedLines,
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
def _write_decorrelated(
    line: NDArray[np.float64], covariance: NDArray[np.float64], k: int, lines: _RefinedLines
) -> None:
    # The fit correlates offset and direction at the midpoint; find the point where they are independent.
    dx, dy = line[1, 0] - line[0, 0], line[1, 1] - line[0, 1]
    length = np.sqrt(dx * dx + dy * dy)
    along = -covariance[0, 1] / covariance[1, 1]
    lines.directions[k, 0], lines.directions[k, 1] = dx / length, dy / length
    for c in range(2):
        lines.middles[k, c] = 0.5 * (line[0, c] + line[1, c]) + along * lines.directions[k, c]
    lines.variances[k, 0] = covariance[0, 0] - covariance[0, 1] ** 2 / covariance[1, 1] + _MODEL_SIGMA**2
    lines.variances[k, 1] = covariance[1, 1]
