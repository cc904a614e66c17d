"""Quadrilaterals: panels, signs, doors; the paper's trapezoid (3.3c, fig. 5) without parallel sides."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.primitives.corner import intersect_lines, intersection_covariance, joint_corner_covariance
from stereo_landmark.core.primitives.corner_links import CornerLinks, link_corners, nearest_links
from stereo_landmark.core.primitives.line_refinement import refine_lines
from stereo_landmark.core.primitives.line_segments import LineSegments
from stereo_landmark.core.primitives.quadrilateral_kernels import (
    CornerGraph,
    best_corner_rotation,
    compare_corners,
    find_cycles,
    positions_along,
    suppress_duplicates,
)
from stereo_landmark.core.primitives.shape import ImagePoint, LazyShapes
from stereo_landmark.core.settings import PrimitiveSettings

# Outlines whose corners differ by less are duplicates [px].
_DUPLICATE_DISTANCE = 4.0
# With more links than this, as small tiles cause them, only the nearest links of each end are kept.
_LINKS_MAX = 12000
_LINKS_PER_END = 4
# Largest motion of a corner by refinement; a larger one belongs to another corner [px].
_SHIFT_MAX = 6.0


@dataclass(frozen=True, eq=False)
class Quadrilateral:
    """A convex quadrilateral in an image; angles are counted from x (right) to y (down).

    Attributes:
        corners: corners, clockwise in the image from the upper left, shape (4, 2) [px].
        polarity: 1 if the inside is bright, -1 if it is dark.
        seen: fraction of the outline with edges.
        covariance: joint covariance of the corners, shape (8, 8) [px²].
    """

    corners: Floats
    polarity: int
    seen: float
    covariance: Floats

    @property
    def centre(self) -> Floats:
        """Centre between the parallel sides, the mean of the corners, shape (2,) [px]."""
        return np.asarray(self.corners.mean(axis=0), dtype=np.float64)

    @property
    def corner_vectors(self) -> Floats:
        """The paper's v1 ... v4, from the centre to the corners, shape (4, 2) [px]."""
        return self.corners - self.centre

    @property
    def shape_vector(self) -> tuple[float, ...]:
        """Corner vectors [px] and polarity."""
        return *self.corner_vectors.ravel(), self.polarity

    def outline(self) -> list[Floats]:
        """Return the closed outline as a polyline, shape (5, 2) [px]."""
        return [np.vstack([self.corners, self.corners[:1]])]

    def image_points(self) -> dict[str, ImagePoint]:
        """Return the candidates for corresponding points, by name: corners and centre."""
        blocks = self.covariance.reshape(4, 2, 4, 2)
        points = {f'corner_{k}': ImagePoint(self.corners[k], blocks[k, :, k, :]) for k in range(len(self.corners))}
        points['centre'] = ImagePoint(self.centre, blocks.sum(axis=(0, 2)) / 16.0)
        return points

    def rotate_corners(self, steps: int) -> Quadrilateral:
        """Return the same quadrilateral with its corners rotated by a number of steps."""
        order = np.roll(np.arange(4), -steps)
        coordinates = (2 * order[:, None] + np.arange(2)).ravel()
        return replace(self, corners=self.corners[order], covariance=self.covariance[np.ix_(coordinates, coordinates)])


@dataclass(frozen=True)
class QuadrilateralTolerance:
    """Tolerances between a detected quadrilateral and the taught one."""

    size: float = setting(0.5, 'relative tolerance of the size', limits=(0.01, 5.0))
    shape: float = setting(
        0.25,
        'largest distance between corners after scaling both to the same size, as a fraction of the size',
        limits=(0.01, 2.0),
    )


def quadrilateral_differences(found: Floats, taught: Floats, tolerance: QuadrilateralTolerance) -> Floats:
    """Return the differences of detected, (n, 9), from taught shape vectors, (k, 9), for any first corner, (k, n)."""
    return np.asarray(compare_corners(found, taught, math.log1p(tolerance.size), tolerance.shape))


def match_corner_order(found: Quadrilateral, taught: Quadrilateral) -> Quadrilateral:
    """Return a detected quadrilateral with its corners in the order of the taught one."""
    return found.rotate_corners(best_corner_rotation(np.array(found.shape_vector), np.array(taught.shape_vector)))


def detect_quadrilaterals(lines: LineSegments, settings: PrimitiveSettings) -> LazyShapes[Quadrilateral]:
    """Detect closed cycles of four line segments; corners may be occluded, sides may have gaps.

    Returns:
        quadrilaterals without duplicates, by falling visible fraction.
    """
    links = link_corners(lines.ends, settings.hidden_corner_max, settings.corner_gap_max, settings.corner_angle_min)
    if len(links.gaps) > _LINKS_MAX:
        links = nearest_links(links, _LINKS_PER_END)
    graph = _corner_graph(links, lines.ends, lines.support, settings.side_seen_min, settings.outline_seen_min)
    cycles, corners, seen = find_cycles(graph)
    corners, cycles = _start_at_upper_left(corners, cycles)
    kept = suppress_duplicates(corners.reshape(-1, 8), np.argsort(-seen, kind='stable'), _DUPLICATE_DISTANCE)
    corners, cycles, seen = corners[kept], cycles[kept], seen[kept]
    polarities = np.where(np.sum(cycles % 2 == 0, axis=1) >= 2, 1, -1)

    def make(k: int) -> Quadrilateral:
        covariance = _covariance(lines, cycles[k] // 2, corners[k])
        return Quadrilateral(corners[k], int(polarities[k]), float(seen[k]), covariance)

    centres = corners.mean(axis=1)
    vectors = (corners - centres[:, None]).reshape(-1, 8)
    return LazyShapes(centres, np.column_stack([vectors, polarities]), make)


def refine_quadrilateral(found: Quadrilateral, image: GreyImage) -> Quadrilateral | None:
    """Refine the four sides in the grey image and intersect them.

    Args:
        found: detected quadrilateral, off by about a pixel at most; occluded parts of its sides are rejected.
        image: grey image, shape (h, w).

    Returns:
        refined quadrilateral with the same corner order and the joint covariance of its corners, None if the
        image does not show four straight sides there.
    """
    lines = refine_lines(image, np.stack([found.corners, np.roll(found.corners, -1, axis=0)], axis=1), True)
    if lines is None:
        return None
    corners = np.array([intersect_lines(lines[k - 1], lines[k]) for k in range(4)])
    if np.abs(corners - found.corners).max() > _SHIFT_MAX:
        return None
    inlier_fraction = float(np.mean([line.inlier_fraction for line in lines]))
    return replace(found, corners=corners, seen=inlier_fraction, covariance=joint_corner_covariance(lines, corners))


def _start_at_upper_left(corners: Floats, cycles: Ints) -> tuple[Floats, Ints]:
    """Return corners and cycles rotated so that the upper left corner is the first."""
    vectors = corners - corners.mean(axis=1, keepdims=True)
    first = np.argmin(vectors.sum(axis=2) / np.linalg.norm(vectors, axis=2), axis=1)
    order = (first[:, None] + np.arange(4)) % 4
    return np.take_along_axis(corners, order[..., None], axis=1), np.take_along_axis(cycles, order, axis=1)


def _covariance(lines: LineSegments, cycle: Ints, corners: Floats) -> Floats:
    """Return the covariance of the corners of one cycle of line segments, shape (8, 8) [px²]."""
    pairs = np.stack([np.roll(cycle, 1), cycle], axis=1)
    ends = lines.ends[pairs]
    directions = ends[:, :, 1] - ends[:, :, 0]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    blocks = intersection_covariance(corners, ends.mean(axis=2), directions, lines.variances[pairs])
    covariance = np.zeros((4, 2, 4, 2))
    corner = np.arange(4)
    covariance[corner, :, corner, :] = blocks
    return covariance.reshape(8, 8)


def _corner_graph(
    links: CornerLinks, ends: Floats, support: Floats, side_seen_min: float, outline_seen_min: float
) -> CornerGraph:
    """Return the graph of the right turns between line segments.

    Args:
        links: pairs of end points.
        ends: end points of the line segments, shape (n, 2, 2) [px].
        support: length of the edges that support each segment, shape (n,) [px].
        side_seen_min: smallest visible fraction of each side.
        outline_seen_min: smallest visible fraction of the whole outline.
    """
    nodes = 2 * links.lines + links.ends
    is_right = links.turns > 0.0
    # In the opposite direction a left turn is a right turn.
    from_ends = np.where(is_right, nodes[:, 0], nodes[:, 1])
    to_ends = np.where(is_right, nodes[:, 1], nodes[:, 0])
    order = np.argsort(from_ends, kind='stable')
    from_ends, to_ends, vertices = from_ends[order], to_ends[order], links.vertices[order]
    incoming = np.argsort(to_ends, kind='stable')
    numbers = np.arange(2 * len(support) + 1)
    starts, incoming_starts = (
        np.searchsorted(sorted_ends, numbers).astype(np.int64) for sorted_ends in (from_ends, to_ends[incoming])
    )
    # The segment that is left was entered at its other end.
    exit_positions = positions_along(ends, from_ends ^ 1, vertices)
    entry_positions = positions_along(ends, to_ends, vertices)
    return CornerGraph(
        *(starts, from_ends, to_ends, vertices, exit_positions, entry_positions, incoming, incoming_starts),
        *(support, side_seen_min, outline_seen_min),
    )
