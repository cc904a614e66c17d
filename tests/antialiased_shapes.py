"""Shapes of known place, sampled as a camera does: blurred, and averaged over the square of each pixel."""

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

# Cells a pixel side, in which the outline's coverage is exact along rows; rows a cell.
_CELLS = 4
_ROWS = 8
Intervals = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]


def ellipse_intervals(centre: ArrayLike, semi_axes: ArrayLike, tilt: float) -> Intervals:
    """Return a function from rows y to where an ellipse begins and ends along x; the same where it is not.

    The centre of the first pixel is (0, 0); the tilt of the first axis is measured from x towards y [rad].
    """
    x0, y0 = np.asarray(centre, dtype=np.float64)
    c, s = math.cos(tilt), math.sin(tilt)
    turn = np.array([[c, -s], [s, c]])
    shape = turn @ np.diag(np.square(np.asarray(semi_axes, dtype=np.float64))) @ turn.T

    def intervals(y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        v = y - y0
        middle = x0 + shape[0, 1] / shape[1, 1] * v
        half = np.sqrt(np.maximum(1.0 - v**2 / shape[1, 1], 0.0) * np.linalg.det(shape) / shape[1, 1])
        return middle - half, middle + half

    return intervals


def polygon_intervals(corners: ArrayLike) -> Intervals:
    """Return a function from rows y to where a convex polygon begins and ends along x; the same where it is not."""
    points = np.asarray(corners, dtype=np.float64)

    def intervals(y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        low, high = np.full(y.shape, np.inf), np.full(y.shape, -np.inf)
        for p, q in zip(points, np.roll(points, -1, axis=0), strict=True):
            if p[1] == q[1]:
                continue
            fraction = (y - p[1]) / (q[1] - p[1])
            inside = (fraction >= 0.0) & (fraction <= 1.0)
            x = p[0] + fraction * (q[0] - p[0])
            low, high = np.where(inside, np.minimum(low, x), low), np.where(inside, np.maximum(high, x), high)
        empty = low > high
        return np.where(empty, 0.0, low), np.where(empty, 0.0, high)

    return intervals


def coverage(intervals: Intervals, size: tuple[int, int], blur: float = 0.0) -> NDArray[np.float64]:
    """Return how much of each pixel a shape covers, seen through a Gaussian blur [px], shape (h, w)."""
    width, height = size
    margin = math.ceil(5.0 * blur) + 1
    columns, rows = (width + 2 * margin) * _CELLS, (height + 2 * margin) * _CELLS
    y = (np.arange(rows * _ROWS) + 0.5) / (_CELLS * _ROWS) - 0.5 - margin
    low, high = ((np.asarray(x) + 0.5 + margin) * _CELLS for x in intervals(y))
    cells = np.arange(columns)
    covered = np.clip(high[:, None] - cells, 0.0, 1.0) - np.clip(low[:, None] - cells, 0.0, 1.0)
    fine = covered.reshape(rows, _ROWS, columns).mean(axis=1)
    if blur > 0.0:
        reach = 2 * math.ceil(5.0 * blur * _CELLS) + 1
        fine = cv2.GaussianBlur(fine, (reach, reach), blur * _CELLS)
    whole = fine.reshape(height + 2 * margin, _CELLS, width + 2 * margin, _CELLS).mean(axis=(1, 3))
    return np.asarray(whole[margin : margin + height, margin : margin + width])


def photograph(light: NDArray[np.float64], noise: float = 0.0, seed: int = 0) -> NDArray[np.uint8]:
    """Return the image of grey levels, shape (h, w), rounded, with normal noise [grey levels] of a seed."""
    rng = np.random.default_rng(seed)
    return np.clip(np.rint(light + noise * rng.standard_normal(np.shape(light))), 0, 255).astype(np.uint8)
