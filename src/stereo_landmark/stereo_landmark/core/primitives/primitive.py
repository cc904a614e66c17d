"""The four kinds of primitives (paper 3.3c) and the operations that they share."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.primitives.corner import Corner, CornerTolerance, corner_differences, refine_corner
from stereo_landmark.core.primitives.ellipse import Ellipse, EllipseTolerance, ellipse_differences, refine_ellipse
from stereo_landmark.core.primitives.parallel_lines import (
    ParallelLines,
    ParallelLinesTolerance,
    parallel_lines_differences,
    refine_parallel_lines,
)
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    QuadrilateralTolerance,
    match_corner_order,
    quadrilateral_differences,
    refine_quadrilateral,
)
from stereo_landmark.core.primitives.shape import LazyShapes
from stereo_landmark.core.settings import EdgeSettings, PrimitiveSettings

Primitive = Ellipse | Quadrilateral | ParallelLines | Corner

DESCRIPTOR_SIZE = 9
SIZE_TOLERANCE = 0.2
"""Tolerance of the logarithm of a size between both cameras."""
ANGLE_TOLERANCE = 0.2
"""Tolerance of a direction [rad]."""
CORNER_TOLERANCE = 0.15
"""Tolerance of a corner of a quadrilateral, as a fraction of its size."""
LENGTH_TOLERANCE = 0.7
"""Tolerance of the logarithm of a length with uncertain end points."""


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


@dataclass(frozen=True)
class ImageProcessing:
    """Image processing parameters of a place, from grey images to primitives (paper 3.3b and c)."""

    edges: EdgeSettings = field(default_factory=EdgeSettings)
    primitives: PrimitiveSettings = field(default_factory=PrimitiveSettings)
    tolerances: Tolerances = field(default_factory=Tolerances)


_KINDS: dict[type[Primitive], PrimitiveKind] = {
    Ellipse: PrimitiveKind.ELLIPSE,
    Quadrilateral: PrimitiveKind.QUADRILATERAL,
    ParallelLines: PrimitiveKind.PARALLEL_LINES,
    Corner: PrimitiveKind.CORNER,
}
_VECTOR_SIZES = {
    PrimitiveKind.ELLIPSE: 4,
    PrimitiveKind.QUADRILATERAL: 9,
    PrimitiveKind.PARALLEL_LINES: 4,
    PrimitiveKind.CORNER: 3,
}


def primitive_kind(primitive: Primitive) -> PrimitiveKind:
    """Return the kind of a primitive."""
    return _KINDS[type(primitive)]


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


def bounding_box(primitive: Primitive) -> Floats:
    """Return the upper left and lower right corner of a primitive's bounding box, shape (2, 2) [px]."""
    points = np.vstack(primitive.outline())
    return np.array([points.min(axis=0), points.max(axis=0)])


def invariant_points(primitive: Primitive) -> tuple[str, ...]:
    """Return the names of the points that are invariant to the viewpoint.

    The mean of the corners of a quadrilateral is not: in an oblique view it moves towards the farther side.
    """
    names = primitive.image_points()
    return tuple(name for name in names if not (isinstance(primitive, Quadrilateral) and name == 'centre'))


def point_names(primitives: Iterable[tuple[str, Primitive]]) -> tuple[str, ...]:
    """Return the names ``primitive/point`` of the invariant points of named primitives."""
    return tuple(f'{name}/{point}' for name, shape in primitives for point in invariant_points(shape))


def drop_covariance(primitive: Primitive) -> Primitive:
    """Return the shape without covariance, as it is taught; the covariance belongs to one image only."""
    return replace(primitive, covariance=np.zeros_like(primitive.covariance))


def shift(primitive: Primitive, offset: Floats) -> Primitive:
    """Return a primitive moved by an offset, shape (2,) [px]."""
    match primitive:
        case Quadrilateral():
            return replace(primitive, corners=primitive.corners + offset)
        case Corner():
            return replace(primitive, vertex=primitive.vertex + offset)
        case _:
            return replace(primitive, centre=primitive.centre + offset)


def align_point_order(found: Primitive, taught: Primitive) -> Primitive:
    """Reorder the points of a detected primitive to correspond to those of a taught one."""
    if isinstance(found, Quadrilateral) and isinstance(taught, Quadrilateral):
        return match_corner_order(found, taught)
    return found


def refine(primitive: Primitive, image: GreyImage) -> Primitive | None:
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


def shape_vectors(kind: PrimitiveKind, primitives: Sequence[Primitive]) -> Floats:
    """Return the shape vectors of primitives of one kind, shape (n, d), independent of their positions."""
    if isinstance(primitives, LazyShapes):
        return primitives.shape_vectors
    vectors = [each.shape_vector for each in primitives]
    return np.array(vectors, dtype=np.float64).reshape(-1, _VECTOR_SIZES[kind])


def difference(found: Primitive, taught: Primitive, tolerances: Tolerances) -> float:
    """Return the shape difference: 0 for equal, 1 at the tolerance, infinite for another kind."""
    kind = primitive_kind(taught)
    if primitive_kind(found) is not kind:
        return math.inf
    vectors = shape_vectors(kind, [found]), shape_vectors(kind, [taught])
    return float(shape_differences(kind, *vectors, tolerances)[0, 0])


def shape_differences(kind: PrimitiveKind, found: Floats, taught: Floats, tolerances: Tolerances) -> Floats:
    """Return the differences between detected and taught shapes, shape (k, n): 0 for equal, 1 at the tolerance.

    Args:
        kind: kind of all the primitives.
        found: shape vectors of the detected primitives, shape (n, d).
        taught: shape vectors of the taught primitives, shape (k, d).
        tolerances: tolerances of the shape comparison.
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


def shape_sizes(kind: PrimitiveKind, vectors: Floats) -> Floats:
    """Return the sizes of shape vectors, shape (n, d), as `primitive_size` does, shape (n,) [px]."""
    match kind:
        case PrimitiveKind.QUADRILATERAL:
            return np.asarray(0.5 * np.linalg.norm(vectors[:, :8], axis=1))
        case PrimitiveKind.CORNER:
            return np.ones(len(vectors))
        case _:
            return vectors[:, 0]


def shape_descriptors(kind: PrimitiveKind, vectors: Floats) -> Floats:
    """Return descriptors, shape (n, DESCRIPTOR_SIZE): primitives are similar if all of theirs differ by less than one.

    Args:
        kind: kind of all the primitives.
        vectors: shape vectors, shape (n, d).
    """
    rows = np.zeros((len(vectors), DESCRIPTOR_SIZE))
    match kind:
        case PrimitiveKind.ELLIPSE:
            flatness = 1.0 - vectors[:, 1] / vectors[:, 0]
            rows[:, :2] = np.log(vectors[:, :2]) / SIZE_TOLERANCE
            rows[:, 2:4] = _doubled_angle_vectors(vectors[:, 2]) * flatness[:, None] / ANGLE_TOLERANCE
            rows[:, 4] = 2.0 * vectors[:, 3]
        case PrimitiveKind.QUADRILATERAL:
            sizes = shape_sizes(kind, vectors)
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


def _doubled_angle_vectors(tilts: Floats) -> Floats:
    """Return undirected angles as half unit vectors of the doubled angle, shape (n, 2)."""
    return 0.5 * np.column_stack([np.cos(2.0 * tilts), np.sin(2.0 * tilts)])
