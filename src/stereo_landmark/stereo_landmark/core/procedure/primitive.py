"""Common operations on all four kinds of primitives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import Corner, CornerTolerance, corner_difference, refine_corner
from stereo_landmark.core.primitives.ellipse import (
    Ellipse,
    EllipseTolerance,
    ellipse_difference,
    refine_ellipse,
)
from stereo_landmark.core.primitives.parallel_lines import (
    ParallelLines,
    ParallelLinesTolerance,
    parallel_lines_difference,
    refine_parallel_lines,
)
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    QuadrilateralTolerance,
    match_corner_order,
    quadrilateral_difference,
    refine_quadrilateral,
)

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
