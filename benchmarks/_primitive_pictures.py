"""Photographs of one ellipse or quadrilateral of known place, their Cramér-Rao bound, and OpenCV's answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from scene_simulator.antialiased_shapes import coverage, ellipse_intervals, photograph, polygon_intervals

_GROUND = 150.0
_SIDES = 4


@dataclass(frozen=True)
class Condition:
    """A photograph's shape: size (semi-axis, half side) and blur [px], contrast and noise [grey levels]."""

    size: float = 20.0
    contrast: float = 80.0
    noise: float = 2.0
    blur: float = 0.7


@dataclass(frozen=True)
class Picture:
    """A photograph, the true coordinates (centre, or corners in order) and their bound.

    Attributes:
        image: shape (h, w).
        truth: shape (n,) [px].
        bound: mean square of the errors of an estimate without bias that reaches the Cramér-Rao bound [px²].
    """

    image: NDArray[np.uint8]
    truth: NDArray[np.float64]
    bound: float


def ellipse_picture(condition: Condition, seed: int) -> Picture:
    """Return a dark ellipse at a random place, flatness and tilt."""
    rng = np.random.default_rng(seed)
    side = 2 * math.ceil(condition.size + 5.0 * condition.blur + 12.0)
    axes = condition.size, condition.size * rng.uniform(0.6, 0.95)
    parameters = np.array([*(0.5 * side + rng.uniform(-0.5, 0.5, 2)), *axes, rng.uniform(-1.5, 1.5)])

    def light(values: NDArray[np.float64]) -> NDArray[np.float64]:
        shape = ellipse_intervals(values[:2], values[2:4], values[4])
        return _GROUND - condition.contrast * coverage(shape, (side, side), condition.blur)

    return _picture(light, parameters, condition, seed, np.arange(2))


def quadrilateral_picture(condition: Condition, seed: int) -> Picture:
    """Return a dark quadrilateral, near a square, at a random place and tilt."""
    rng = np.random.default_rng(seed)
    side = 2 * math.ceil(1.8 * condition.size + 5.0 * condition.blur + 12.0)
    square = condition.size * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    square += rng.uniform(-0.2, 0.2, (4, 2)) * condition.size
    angle = rng.uniform(-0.7, 0.7)
    c, s = math.cos(angle), math.sin(angle)
    corners = square @ np.array([[c, s], [-s, c]]) + 0.5 * side + rng.uniform(-0.5, 0.5, 2)

    def light(values: NDArray[np.float64]) -> NDArray[np.float64]:
        shape = polygon_intervals(values.reshape(4, 2))
        return _GROUND - condition.contrast * coverage(shape, (side, side), condition.blur)

    return _picture(light, corners.ravel(), condition, seed, np.arange(8))


def _picture(
    light: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    parameters: NDArray[np.float64],
    condition: Condition,
    seed: int,
    wanted: NDArray[np.int64],
) -> Picture:
    image = light(parameters)
    steps = 0.02 * np.eye(len(parameters))
    columns = [(light(parameters + step) - light(parameters - step)).ravel() / 0.04 for step in steps]
    # Nobody knows the two grey levels beforehand.
    columns += [np.ones(image.size), (image - _GROUND).ravel()]
    jacobian = np.column_stack(columns)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * (condition.noise**2 + 1.0 / 12.0)
    bound = float(np.mean(np.diag(covariance)[wanted]))
    return Picture(photograph(image, condition.noise, seed), parameters[wanted], bound)


def contour_centre(image: NDArray[np.uint8]) -> NDArray[np.float64] | None:
    """Return the centre that Otsu's threshold, the longest contour and cv2.fitEllipseDirect give, shape (2,)."""
    _, binary = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    contours, _ = cv2.findContours(binary, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    longest = max(contours, key=len, default=())
    return np.array(cv2.fitEllipseDirect(longest)[0]) if len(longest) >= 6 else None


def lsd_corners(image: NDArray[np.uint8], corners: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the corners where cv2's LSD segments along the true sides meet, shape (8,); None where one lacks.

    The peer selects by ground truth: of the segments along a side it takes the longest.

    Args:
        image: shape (h, w).
        corners: shape (8,), true corners [px].
    """
    found = cv2.createLineSegmentDetector().detect(image)[0]
    if found is None:
        return None
    lines = []
    truth = corners.reshape(4, 2)
    for k in range(_SIDES):
        line = _longest_segment_along(
            found.reshape(-1, 2, 2).astype(np.float64), truth[k], truth[(k + 1) % _SIDES]
        )
        if line is None:
            return None
        lines.append(line)
    return np.concatenate([_intersection(lines[k - 1], lines[k]) for k in range(_SIDES)])


def _longest_segment_along(
    segments: NDArray[np.float64], begin: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    direction = (end - begin) / np.hypot(*(end - begin))
    across = np.abs((segments - begin) @ np.array([-direction[1], direction[0]])).max(axis=1)
    lengths = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    lengths[across > 2.0] = 0.0
    return segments[np.argmax(lengths)] if lengths.max() > 0.0 else None


def _intersection(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    a, b = one[1] - one[0], other[1] - other[0]
    along = np.linalg.solve(np.column_stack([a, -b]), other[0] - one[0])
    return np.asarray(one[0] + along[0] * a, dtype=np.float64)
