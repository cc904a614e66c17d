"""Shape vectors and descriptors of primitives, for vectorized comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import corner_differences, corner_numbers
from stereo_landmark.core.primitives.ellipse import ellipse_differences, ellipse_numbers
from stereo_landmark.core.primitives.found_shapes import FoundShapes
from stereo_landmark.core.primitives.parallel_lines import parallel_lines_differences, parallel_lines_numbers
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    quadrilateral_differences,
    quadrilateral_numbers,
)
from stereo_landmark.core.procedure.primitive import Kind, Primitive, Tolerances

DESCRIPTORS = 9
SIZE_STEP = 0.2
"""Tolerance of the logarithm of a size between both cameras."""
ANGLE_STEP = 0.2
"""Tolerance of a direction [rad]."""
CORNER_STEP = 0.15
"""Tolerance of a corner of a quadrilateral, as a fraction of its size."""
LENGTH_STEP = 0.7
"""Tolerance of the logarithm of a length with uncertain end points."""

_NUMBERS: dict[Kind, Callable[[Sequence[Any]], NDArray[np.float64]]] = {
    Kind.ELLIPSE: ellipse_numbers,
    Kind.QUADRILATERAL: quadrilateral_numbers,
    Kind.PARALLEL_LINES: parallel_lines_numbers,
    Kind.CORNER: corner_numbers,
}


def numbers_of(kind: Kind, primitives: Sequence[Primitive]) -> NDArray[np.float64]:
    """Return the shape vectors of primitives of one kind, shape (n, d), independent of their positions."""
    return _NUMBERS[kind](primitives)


def centres_of(kind: Kind, primitives: Sequence[Primitive]) -> NDArray[np.float64]:
    """Return the centres of primitives of one kind, shape (n, 2) [px]."""
    if isinstance(primitives, FoundShapes):
        return primitives.centres
    if kind is Kind.QUADRILATERAL:
        corners = [each.corners for each in primitives if isinstance(each, Quadrilateral)]
        return np.asarray(np.array(corners).reshape(-1, 4, 2).mean(axis=1))
    return np.array([each.centre for each in primitives]).reshape(-1, 2)


def differences(
    kind: Kind, found: NDArray[np.float64], taught: NDArray[np.float64], tolerances: Tolerances
) -> NDArray[np.float64]:
    """Return the differences between detected and taught shapes: 0 for equal, 1 at the tolerance.

    Args:
        kind: kind of all the primitives.
        found: detected shapes, shape (n, d), see :func:`numbers_of`.
        taught: taught shapes, shape (k, d).
        tolerances: tolerances of the shape comparison.

    Returns:
        differences, shape (k, n).
    """
    match kind:
        case Kind.ELLIPSE:
            return ellipse_differences(found, taught, tolerances.ellipse)
        case Kind.QUADRILATERAL:
            return quadrilateral_differences(found, taught, tolerances.quadrilateral)
        case Kind.PARALLEL_LINES:
            return parallel_lines_differences(found, taught, tolerances.parallel_lines)
        case Kind.CORNER:
            return corner_differences(found, taught, tolerances.corner)


def descriptors_of(kind: Kind, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return descriptors: two primitives of a kind are similar if all their descriptors differ by less than one.

    Args:
        kind: kind of all the primitives.
        numbers: shape vectors, shape (n, d), see :func:`numbers_of`.

    Returns:
        descriptors, shape (n, DESCRIPTORS).
    """
    rows = np.zeros((len(numbers), DESCRIPTORS))
    match kind:
        case Kind.ELLIPSE:
            flatness = 1.0 - numbers[:, 1] / numbers[:, 0]
            rows[:, :2] = np.log(numbers[:, :2]) / SIZE_STEP
            rows[:, 2:4] = _lines(numbers[:, 2]) * flatness[:, None] / ANGLE_STEP
            rows[:, 4] = 2.0 * numbers[:, 3]
        case Kind.QUADRILATERAL:
            sizes = 0.5 * np.linalg.norm(numbers[:, :8], axis=1)
            rows[:, :8] = numbers[:, :8] / (sizes[:, None] * CORNER_STEP)
            rows[:, 8] = np.log(sizes) / SIZE_STEP + 100.0 * numbers[:, 8]
        case Kind.PARALLEL_LINES:
            rows[:, 0] = np.log(numbers[:, 0]) / SIZE_STEP
            rows[:, 1:3] = _lines(numbers[:, 2]) / ANGLE_STEP
            rows[:, 3] = np.log(numbers[:, 1]) / LENGTH_STEP
            rows[:, 4] = 2.0 * numbers[:, 3]
        case Kind.CORNER:
            rows[:, 0] = numbers[:, 0] / ANGLE_STEP
            rows[:, 1:3] = np.column_stack([np.cos(numbers[:, 1]), np.sin(numbers[:, 1])]) / ANGLE_STEP
            rows[:, 3] = 2.0 * numbers[:, 2]
    return rows


def _lines(tilts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return undirected angles as half unit vectors of the doubled angle, shape (n, 2)."""
    return 0.5 * np.column_stack([np.cos(2.0 * tilts), np.sin(2.0 * tilts)])
