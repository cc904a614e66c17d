"""Painting of polygons with exact area coverage of every pixel, so that edges carry the sub-pixel truth."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


def paint_polygons(
    layer: NDArray[np.float32],
    covered: NDArray[np.float32],
    corners: NDArray[np.float64],
    colours: NDArray[np.float64],
    opacities: NDArray[np.float64],
) -> None:
    """Paint polygons over a picture, one after the other.

    A pixel that a polygon covers by the fraction a becomes ``(1 - a * opacity) * pixel + a * opacity * colour``.

    Args:
        layer: shape (height, width, channels), the picture, changed in place.
        covered: shape (height, width), fraction of each pixel that is hidden, changed in place in the same way.
        corners: shape (n, v, 2), u and v [px], origin in the centre of the upper left pixel.
        colours: shape (n, channels).
        opacities: shape (n,), 0 to 1.
    """
    if len(corners):
        _paint(layer, covered, corners + 0.5, colours, opacities)


@njit(cache=True)
def _paint(
    layer: NDArray[np.float32],
    covered: NDArray[np.float32],
    corners: NDArray[np.float64],
    colours: NDArray[np.float64],
    opacities: NDArray[np.float64],
) -> None:
    height, width, channels = layer.shape
    for k in range(len(corners)):
        polygon = corners[k]
        left = max(0, math.floor(polygon[:, 0].min()))
        right = min(width, math.ceil(polygon[:, 0].max()))
        top = max(0, math.floor(polygon[:, 1].min()))
        bottom = min(height, math.ceil(polygon[:, 1].max()))
        if left >= right or top >= bottom:
            continue
        coverage = _coverage(polygon, left, right, top, bottom)
        for row in range(top, bottom):
            for column in range(left, right):
                alpha = min(abs(coverage[row - top, column - left]), 1.0) * opacities[k]
                covered[row, column] += (1.0 - covered[row, column]) * alpha
                for channel in range(channels):
                    pixel = layer[row, column, channel]
                    layer[row, column, channel] = pixel + alpha * (colours[k, channel] - pixel)


@njit(cache=True)
def _coverage(
    polygon: NDArray[np.float64], left: int, right: int, top: int, bottom: int
) -> NDArray[np.float64]:
    """Return the signed fraction of each pixel of a window that is inside a polygon.

    The area right of an edge within a pixel is the integral over the edge's rise of the part of the pixel's
    width that is right of the edge; summed with sign over all edges it is the polygon's area in the pixel.
    """
    coverage = np.zeros((bottom - top, right - left))
    for i in range(len(polygon)):
        x0, y0 = polygon[i - 1]
        x1, y1 = polygon[i]
        if y0 == y1:
            continue
        slope = (x1 - x0) / (y1 - y0)
        low, high = max(min(y0, y1), top), min(max(y0, y1), bottom)
        sign = 1.0 if y1 > y0 else -1.0
        for row in range(math.floor(low), math.ceil(high)):
            enter, leave = max(low, row), min(high, row + 1)
            xa, xb = x0 + slope * (enter - y0), x0 + slope * (leave - y0)
            for column in range(max(left, math.floor(min(xa, xb))), right):
                width = _mean_width(column + 1.0 - xa, column + 1.0 - xb)
                coverage[row - top, column - left] += sign * width * (leave - enter)
    return coverage


@njit(cache=True)
def _mean_width(a: float, b: float) -> float:
    """Return the mean of clip(t, 0, 1) for t between a and b."""
    if abs(a - b) < 1e-9:
        return min(max(0.5 * (a + b), 0.0), 1.0)
    return (_clip_integral(a) - _clip_integral(b)) / (a - b)


@njit(cache=True)
def _clip_integral(t: float) -> float:
    """Return the integral of clip(s, 0, 1) over s from 0 to t."""
    if t <= 0.0:
        return 0.0
    return 0.5 * t * t if t < 1.0 else t - 0.5
