"""The pixels in a band along a straight edge, and the effect of an adjacent edge on them near a corner."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.edge_profiles import BandPixels
from stereo_landmark.core.primitives.edge_response import direction_bin, interpolate_response


@njit(cache=True, error_model='numpy')
def apply_adjacent_edge(
    other: NDArray[np.float64],
    middle: tuple[float, float],
    direction: tuple[float, float],
    curves: NDArray[np.float64],
    variance: float,
    pixels: BandPixels,
    positions: NDArray[np.float64],
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
    image: NDArray[np.uint8],
    middle: tuple[float, float],
    direction: tuple[float, float],
    span: float,
    width: float,
    count: int,
) -> tuple[BandPixels, NDArray[np.float64]]:
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
    return BandPixels(
        profiles[:n], distances[:n], directions, values[:n], np.ones(n), np.zeros(n)
    ), positions[:n]


@njit(cache=True, error_model='numpy')
def _row_interval(
    ey: float, dx: float, dy: float, span: float, width: float, extent_x: float
) -> tuple[float, float]:
    """Return the interval of x, from the middle, in which an image row crosses the band [px]."""
    low, high = -extent_x, extent_x
    if abs(dy) > 0.05:
        ends = (dx * ey - width) / dy, (dx * ey + width) / dy
        low, high = max(low, min(ends)), min(high, max(ends))
    if abs(dx) > 0.05:
        ends = (-0.5 * span - dy * ey) / dx, (0.5 * span - dy * ey) / dx
        low, high = max(low, min(ends)), min(high, max(ends))
    return low - 1.0, high
