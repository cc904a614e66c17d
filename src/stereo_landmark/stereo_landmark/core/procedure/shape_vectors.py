"""Shape vectors and descriptors of primitives, for vectorized comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import corner_differences, corner_shape_vectors
from stereo_landmark.core.primitives.ellipse import ellipse_differences, ellipse_shape_vectors
from stereo_landmark.core.primitives.lazy_shapes import LazyShapes
from stereo_landmark.core.primitives.parallel_lines import (
    parallel_lines_differences,
    parallel_lines_shape_vectors,
)
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    quadrilateral_differences,
    quadrilateral_shape_vectors,
)
from stereo_landmark.core.procedure.primitive import Primitive, PrimitiveKind, Tolerances

DESCRIPTOR_SIZE = 9
SIZE_TOLERANCE = 0.2
"""Tolerance of the logarithm of a size between both cameras."""
ANGLE_TOLERANCE = 0.2
"""Tolerance of a direction [rad]."""
CORNER_TOLERANCE = 0.15
"""Tolerance of a corner of a quadrilateral, as a fraction of its size."""
LENGTH_TOLERANCE = 0.7
"""Tolerance of the logarithm of a length with uncertain end points."""

_SHAPE_VECTORS: dict[PrimitiveKind, Callable[[Sequence[Any]], NDArray[np.float64]]] = {
    PrimitiveKind.ELLIPSE: ellipse_shape_vectors,
    PrimitiveKind.QUADRILATERAL: quadrilateral_shape_vectors,
    PrimitiveKind.PARALLEL_LINES: parallel_lines_shape_vectors,
    PrimitiveKind.CORNER: corner_shape_vectors,
}


def shape_vectors(kind: PrimitiveKind, primitives: Sequence[Primitive]) -> NDArray[np.float64]:
    """Return the shape vectors of primitives of one kind, shape (n, d), independent of their positions."""
    return _SHAPE_VECTORS[kind](primitives)


def primitive_centres(kind: PrimitiveKind, primitives: Sequence[Primitive]) -> NDArray[np.float64]:
    """Return the centres of primitives of one kind, shape (n, 2) [px]."""
    if isinstance(primitives, LazyShapes):
        return primitives.centres
    if kind is PrimitiveKind.QUADRILATERAL:
        corners = [each.corners for each in primitives if isinstance(each, Quadrilateral)]
        return np.asarray(np.array(corners).reshape(-1, 4, 2).mean(axis=1))
    return np.array([each.centre for each in primitives]).reshape(-1, 2)


def shape_differences(
    kind: PrimitiveKind, found: NDArray[np.float64], taught: NDArray[np.float64], tolerances: Tolerances
) -> NDArray[np.float64]:
    """Return the differences between detected and taught shapes: 0 for equal, 1 at the tolerance.

    Args:
        kind: kind of all the primitives.
        found: detected shapes, shape (n, d), see :func:`shape_vectors`.
        taught: taught shapes, shape (k, d).
        tolerances: tolerances of the shape comparison.

    Returns:
        differences, shape (k, n).
    """
    match kind:
        case PrimitiveKind.ELLIPSE:
            return ellipse_differences(found, taught, tolerances.ellipse)
        case PrimitiveKind.QUADRILATERAL:
            return quadrilateral_differences(found, taught, tolerances.quadrilateral)
        case PrimitiveKind.PARALLEL_LINES:
            return parallel_lines_differences(found, taught, tolerances.parallel_lines)
        case PrimitiveKind.CORNER:
            return corner_differences(found, taught, tolerances.corner)


def shape_descriptors(kind: PrimitiveKind, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return descriptors: two primitives of a kind are similar if all their descriptors differ by less than one.

    Args:
        kind: kind of all the primitives.
        vectors: shape vectors, shape (n, d), see :func:`shape_vectors`.

    Returns:
        descriptors, shape (n, DESCRIPTORS).
    """
    rows = np.zeros((len(vectors), DESCRIPTOR_SIZE))
    match kind:
        case PrimitiveKind.ELLIPSE:
            flatness = 1.0 - vectors[:, 1] / vectors[:, 0]
            rows[:, :2] = np.log(vectors[:, :2]) / SIZE_TOLERANCE
            rows[:, 2:4] = _doubled_angle_vectors(vectors[:, 2]) * flatness[:, None] / ANGLE_TOLERANCE
            rows[:, 4] = 2.0 * vectors[:, 3]
        case PrimitiveKind.QUADRILATERAL:
            sizes = 0.5 * np.linalg.norm(vectors[:, :8], axis=1)
            rows[:, :8] = vectors[:, :8] / (sizes[:, None] * CORNER_TOLERANCE)
            rows[:, 8] = np.log(sizes) / SIZE_TOLERANCE + 100.0 * vectors[:, 8]
        case PrimitiveKind.PARALLEL_LINES:
            rows[:, 0] = np.log(vectors[:, 0]) / SIZE_TOLERANCE
            rows[:, 1:3] = _doubled_angle_vectors(vectors[:, 2]) / ANGLE_TOLERANCE
            rows[:, 3] = np.log(vectors[:, 1]) / LENGTH_TOLERANCE
            rows[:, 4] = 2.0 * vectors[:, 3]
        case PrimitiveKind.CORNER:
            rows[:, 0] = vectors[:, 0] / ANGLE_TOLERANCE
            rows[:, 1:3] = np.column_stack([np.cos(vectors[:, 1]), np.sin(vectors[:, 1])]) / ANGLE_TOLERANCE
            rows[:, 3] = 2.0 * vectors[:, 2]
    return rows


def _doubled_angle_vectors(tilts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return undirected angles as half unit vectors of the doubled angle, shape (n, 2)."""
    return 0.5 * np.column_stack([np.cos(2.0 * tilts), np.sin(2.0 * tilts)])
