"""The four kinds of primitives and the operations that they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import (
    Corner,
    CornerTolerance,
    corner_difference,
    corner_differences,
    corner_shape_vectors,
    refine_corner,
)
from stereo_landmark.core.primitives.ellipse import (
    Ellipse,
    EllipseTolerance,
    ellipse_difference,
    ellipse_differences,
    ellipse_shape_vectors,
    refine_ellipse,
)
from stereo_landmark.core.primitives.parallel_lines import (
    ParallelLines,
    ParallelLinesTolerance,
    parallel_lines_difference,
    parallel_lines_differences,
    parallel_lines_shape_vectors,
    refine_parallel_lines,
)
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    QuadrilateralTolerance,
    match_corner_order,
    quadrilateral_difference,
    quadrilateral_differences,
    quadrilateral_shape_vectors,
    refine_quadrilateral,
)
from stereo_landmark.core.primitives.shape import LazyShapes

Primitive = Ellipse | Quadrilateral | ParallelLines | Corner


class PrimitiveKind(Enum):
    """Kind of a primitive, with its name in files and on the teaching page."""

    ELLIPSE = 'ellipse'
    QUADRILATERAL = 'quadrilateral'
    PARALLEL_LINES = 'parallel_lines'
    CORNER = 'corner'


@dataclass(frozen=True)
class Tolerances:
    """Tolerances between detected and taught shapes, for each kind."""

    ellipse: EllipseTolerance = field(default_factory=EllipseTolerance)
    quadrilateral: QuadrilateralTolerance = field(default_factory=QuadrilateralTolerance)
    parallel_lines: ParallelLinesTolerance = field(default_factory=ParallelLinesTolerance)
    corner: CornerTolerance = field(default_factory=CornerTolerance)


def primitive_kind(primitive: Primitive) -> PrimitiveKind:
    """Return the kind of a primitive."""
    match primitive:
        case Ellipse():
            return PrimitiveKind.ELLIPSE
        case Quadrilateral():
            return PrimitiveKind.QUADRILATERAL
        case ParallelLines():
            return PrimitiveKind.PARALLEL_LINES
        case Corner():
            return PrimitiveKind.CORNER


def refine_pair(
    left: Primitive, right: Primitive, images: tuple[NDArray[np.uint8], NDArray[np.uint8]]
) -> tuple[Primitive, Primitive] | None:
    """Refine a primitive in both grey images, shapes (h, w); None if it is not visible in one of them."""
    here, there = refine(left, images[0]), refine(right, images[1])
    return None if here is None or there is None else (here, there)


def align_point_order(found: Primitive, taught: Primitive) -> Primitive:
    """Reorder the points of a detected primitive to correspond to those of a taught one."""
    if isinstance(found, Quadrilateral) and isinstance(taught, Quadrilateral):
        return match_corner_order(found, taught)
    return found


def difference(found: Primitive, taught: Primitive, tolerances: Tolerances) -> float:
    """Return the shape difference: 0 for equal, 1 at the tolerance, infinite for another kind."""
    match found, taught:
        case Ellipse(), Ellipse():
            return ellipse_difference(found, taught, tolerances.ellipse)
        case Quadrilateral(), Quadrilateral():
            return quadrilateral_difference(found, taught, tolerances.quadrilateral)
        case ParallelLines(), ParallelLines():
            return parallel_lines_difference(found, taught, tolerances.parallel_lines)
        case Corner(), Corner():
            return corner_difference(found, taught, tolerances.corner)
    return math.inf


def refine(primitive: Primitive, image: NDArray[np.uint8]) -> Primitive | None:
    """Refine a detected primitive in the grey image, shape (h, w); None if it is not visible."""
    match primitive:
        case Ellipse():
            return refine_ellipse(primitive, image)
        case Quadrilateral():
            return refine_quadrilateral(primitive, image)
        case ParallelLines():
            return refine_parallel_lines(primitive, image)
        case Corner():
            return refine_corner(primitive, image)


def drop_covariance(primitive: Primitive) -> Primitive:
    """Return the shape without covariance, as it is taught; the covariance belongs to one image only."""
    return replace(primitive, covariance=np.zeros_like(primitive.covariance))


def primitive_size(primitive: Primitive) -> float:
    """Return the size of a primitive: semi-major axis, half diagonal or width [px]; 1 for corners."""
    match primitive:
        case Ellipse():
            return float(primitive.semi_axes[0])
        case Quadrilateral():
            return float(np.linalg.norm(primitive.corner_vectors) / 2.0)
        case ParallelLines():
            return primitive.width
        case Corner():
            return 1.0


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
