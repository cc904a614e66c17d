"""Projection of shape outlines: clipping to the view frustum, lens distortion, clipping to the image."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

NEAR = 0.05
"""Near clipping distance [m]."""

_MAX_CHORD = 6.0
"""Longest chord of an outline behind a distorting lens [px]: it is off by 0.002 px."""


@njit(cache=True, error_model='numpy')
def project_outline(
    points: NDArray[np.float64],
    planes: NDArray[np.float64],
    lens: NDArray[np.float64],
    size: tuple[int, int],
    scale: float,
) -> NDArray[np.float64]:
    """Return the part of an outline that is in the picture, shape (n, 2), n = 0 where nothing is.

    Args:
        points: shape (n, 3), the outline in the optical frame [m].
        planes: shape (m, 4), half spaces that hold the view, see ``view_planes``.
        lens: fx, fy, cx, cy, k1, k2, p1, p2, k3 of the picture.
        size: width and height of the picture [px].
        scale: samples per pixel along each side.

    Returns:
        corners in samples; the picture's upper left corner is the origin, not its first sample's centre.
    """
    seen = points
    for plane in planes:
        seen = _clip_to_half_space(seen, plane)
        if len(seen) < 3:
            return np.empty((0, 2))
    flat = _project(seen, lens)
    picture = np.empty((len(flat), 3))
    for k in range(len(flat)):
        picture[k, 0], picture[k, 1] = scale * (flat[k, 0] + 0.5), scale * (flat[k, 1] + 0.5)
        picture[k, 2] = 1.0
    width, height = float(scale * size[0]), float(scale * size[1])
    borders = np.array([[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, width, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, -1.0, height, 0.0]])
    for border in borders:
        picture = _clip_to_half_space(picture, border)
        if len(picture) < 3:
            return np.empty((0, 2))
    corners = np.empty((len(picture), 2))
    for k in range(len(picture)):
        corners[k, 0] = min(max(picture[k, 0], 0.0), width)
        corners[k, 1] = min(max(picture[k, 1], 0.0), height)
    return corners


def view_planes(rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the half spaces that hold all that a camera sees, and little more, shape (5, 4).

    A row (a, b, c, d) is the half space ``a x + b y + c z + d >= 0`` of the optical frame.

    Args:
        rays: shape (height, width, 2), the undistorted rays of the samples, z = 1.
    """
    low, high = rays.reshape(-1, 2).min(axis=0), rays.reshape(-1, 2).max(axis=0)
    margin = 0.02 * (high - low)
    (left, top), (right, bottom) = low - margin, high + margin
    rows = [(0, 0, 1, -NEAR), (1, 0, -left, 0), (-1, 0, right, 0), (0, 1, -top, 0), (0, -1, bottom, 0)]
    return np.array(rows, dtype=np.float64)


@njit(cache=True, error_model='numpy')
def _clip_to_half_space(points: NDArray[np.float64], plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part of an outline in a half space (Sutherland and Hodgman), shape (m, 3)."""
    n = len(points)
    heights = np.empty(n)
    inside = 0
    for i in range(n):
        x, y, z = points[i]
        heights[i] = plane[0] * x + plane[1] * y + plane[2] * z + plane[3]
        if heights[i] >= 0.0:
            inside += 1
    if inside == n:
        return points
    kept = np.empty((2 * n, 3))
    count = 0
    for i in range(n):
        before, here = heights[i - 1], heights[i]
        if (before >= 0.0) != (here >= 0.0):
            for k in range(3):
                kept[count, k] = points[i - 1, k] + before / (before - here) * (points[i, k] - points[i - 1, k])
            count += 1
        if here >= 0.0:
            for k in range(3):
                kept[count, k] = points[i, k]
            count += 1
    return kept[:count]


@njit(cache=True, error_model='numpy')
def _project(points: NDArray[np.float64], lens: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the picture of an outline, shape (m, 2) [px]; its sides are bent where the lens distorts."""
    n = len(points)
    chord_counts = np.ones(n, dtype=np.int64)
    if np.any(lens[4:] != 0.0):
        for i in range(n):
            dx = points[i, 0] / points[i, 2] - points[i - 1, 0] / points[i - 1, 2]
            dy = points[i, 1] / points[i, 2] - points[i - 1, 1] / points[i - 1, 2]
            chord_counts[i] = max(1, math.ceil(math.hypot(lens[0] * dx, lens[1] * dy) / _MAX_CHORD))
    flat = np.empty((chord_counts.sum(), 2))
    count = 0
    for i in range(n):
        x0, y0 = points[i - 1, 0] / points[i - 1, 2], points[i - 1, 1] / points[i - 1, 2]
        x1, y1 = points[i, 0] / points[i, 2], points[i, 1] / points[i, 2]
        for k in range(1, chord_counts[i] + 1):
            fraction = k / chord_counts[i]
            place = _distort(x0 + fraction * (x1 - x0), y0 + fraction * (y1 - y0), lens)
            flat[count, 0], flat[count, 1] = place
            count += 1
    return flat


@njit(cache=True, error_model='numpy')
def _distort(x: float, y: float, lens: NDArray[np.float64]) -> tuple[float, float]:
    """Return the pixel of a ray (x, y, 1) behind a ``plumb_bob`` lens."""
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return lens[0] * xd + lens[2], lens[1] * yd + lens[3]
