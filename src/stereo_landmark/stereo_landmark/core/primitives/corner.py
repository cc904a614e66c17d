"""Corners: two straight arms that intersect at a vertex (paper 3.3c); intersections of lines and their covariance."""

import math
from dataclasses import dataclass

import numpy as np

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.primitives.corner_links import link_corners
from stereo_landmark.core.primitives.line_refinement import RefinedLine, refine_lines
from stereo_landmark.core.primitives.line_segments import LineSegments
from stereo_landmark.core.primitives.shape import ImagePoint, LazyShapes, wrap_differences
from stereo_landmark.core.settings import PrimitiveSettings

# The intersection of arms with a smaller angle is ill-conditioned.
_SINE_MIN = 0.1


@dataclass(frozen=True, eq=False)
class Corner:
    """A corner in an image; angles are counted from x (right) to y (down).

    Attributes:
        vertex: intersection of the lines of both arms, shape (2,) [px].
        angle: angle between the arms, in (0, pi) [rad].
        bisector: direction from the vertex into the corner, in (-pi, pi] [rad].
        arm_lengths: lengths of the arms, first the arm from which the angle is counted, shape (2,) [px].
        polarity: 1 if the inside is bright, -1 if it is dark, 0 if the arms differ.
        covariance: covariance of the vertex, shape (2, 2) [px²].
    """

    vertex: Floats
    angle: float
    bisector: float
    arm_lengths: Floats
    polarity: int
    covariance: Floats

    @property
    def centre(self) -> Floats:
        """The vertex, shape (2,) [px]."""
        return self.vertex

    @property
    def arms(self) -> Floats:
        """Unit vectors from the vertex along both arms, shape (2, 2)."""
        angles = self.bisector + 0.5 * self.angle * np.array([-1.0, 1.0])
        return np.column_stack([np.cos(angles), np.sin(angles)])

    @property
    def shape_vector(self) -> tuple[float, ...]:
        """Angle and bisector [rad] and polarity."""
        return self.angle, self.bisector, self.polarity

    def outline(self) -> list[Floats]:
        """Return both arms as one polyline, shape (3, 2) [px]."""
        ends = self.vertex + self.arms * self.arm_lengths[:, None]
        return [np.array([ends[0], self.vertex, ends[1]])]

    def image_points(self) -> dict[str, ImagePoint]:
        """Return the candidates for corresponding points, by name."""
        return {'vertex': ImagePoint(self.vertex, self.covariance)}


@dataclass(frozen=True)
class CornerTolerance:
    """Tolerances between a detected corner and the taught one."""

    angle: float = setting(0.35, 'tolerance of the angle', 'rad', (0.01, 1.5))
    bisector: float = setting(0.35, 'tolerance of the bisector', 'rad', (0.01, 3.2))


def corner_differences(found: Floats, taught: Floats, tolerance: CornerTolerance) -> Floats:
    """Return the differences of detected, shape (n, 3), from taught shape vectors, shape (k, 3): shape (k, n)."""
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    angles = np.abs(mine[0] - theirs[0]) / tolerance.angle
    bisectors = np.abs(wrap_differences(mine[1] - theirs[1], 2.0 * math.pi)) / tolerance.bisector
    return np.where(mine[2] == theirs[2], np.maximum(angles, bisectors), math.inf)


def detect_corners(lines: LineSegments, settings: PrimitiveSettings) -> LazyShapes[Corner]:
    """Detect the corners of intersecting line segments.

    Returns:
        corners without duplicates, by falling arm length.
    """
    gap = settings.corner_gap_max
    links = link_corners(lines.ends, gap, gap, settings.corner_angle_min)
    i, e = links.lines, links.ends
    inner, outer = lines.ends[i, 1 - e], lines.ends[i, e]
    arms = inner - outer
    lengths = np.hypot(arms[..., 0], arms[..., 1])
    arms = arms / lengths[..., None]
    linked_arms, middles = arms.copy(), 0.5 * (inner + outer)
    # The angle is counted from the first arm to the second one; swap the arms if it is negative.
    swapped = arms[:, 0, 0] * arms[:, 1, 1] - arms[:, 0, 1] * arms[:, 1, 0] < 0.0
    for array in (arms, lengths, e):
        array[swapped] = array[swapped, ::-1]
    lengths = lengths + np.where(swapped[:, None], links.gaps[:, ::-1], links.gaps)
    angles = np.arccos(np.clip(np.sum(arms[:, 0] * arms[:, 1], axis=1), -1.0, 1.0))
    middle = arms.sum(axis=1)
    bisectors = np.arctan2(middle[:, 1], middle[:, 0])
    # The inside is to the right of the first arm seen from the vertex: bright if the segment starts there.
    bright = np.column_stack([e[:, 0] == 0, e[:, 1] == 1])
    polarities = np.where(bright[:, 0] == bright[:, 1], np.where(bright[:, 0], 1, -1), 0)
    kept = _suppress_duplicates(links.vertices, bisectors, lengths.min(axis=1))
    numbers = np.column_stack([angles, bisectors, polarities])[kept]

    def make(number: int) -> Corner:
        k = kept[number]
        covariance = intersection_covariance(
            links.vertices[k, None], middles[k, None], linked_arms[k, None], lines.variances[i[k]][None]
        )
        angle, bisector, polarity = numbers[number].tolist()
        return Corner(links.vertices[k], angle, bisector, lengths[k], int(polarity), covariance[0])

    return LazyShapes(links.vertices[kept], numbers, make)


def refine_corner(corner: Corner, image: GreyImage) -> Corner | None:
    """Refine both arms in the grey image and intersect them.

    Args:
        corner: detected corner, off by about a pixel at most.
        image: grey image, shape (h, w).

    Returns:
        refined corner, None if the image does not show two straight edges there.
    """
    arm_ends = corner.vertex + corner.arms * corner.arm_lengths[:, None]
    arms = refine_lines(image, np.stack([np.tile(corner.vertex, (2, 1)), arm_ends], axis=1))
    if arms is None or abs(_cross(arms[0].direction, arms[1].direction)) < _SINE_MIN:
        return None
    first, second = arms
    vertex, covariance = intersect_with_covariance(first, second)
    middle = first.direction + second.direction
    return Corner(
        vertex,
        math.acos(min(max(float(first.direction @ second.direction), -1.0), 1.0)),
        math.atan2(middle[1], middle[0]),
        np.array([(arm_end - vertex) @ arm.direction for arm_end, arm in zip(arm_ends, (first, second), strict=True)]),
        corner.polarity,
        covariance,
    )


def _cross(one: Floats, other: Floats) -> float:
    return float(one[0] * other[1] - one[1] * other[0])


def _suppress_duplicates(vertices: Floats, bisectors: Floats, lengths: Floats) -> Ints:
    """Return one corner per cell of position and direction, the one with the longest arms, by falling arm length."""
    cells = np.column_stack([vertices / 2.0, bisectors / 0.3])
    keys = np.rint(cells).astype(np.int64) @ [1 << 40, 1 << 16, 1]
    order = np.argsort(-lengths, kind='stable')
    _, first = np.unique(keys[order], return_index=True)
    return np.asarray(order[np.sort(first)], dtype=np.int64)


def intersection_covariance(vertices: Floats, middles: Floats, directions: Floats, variances: Floats) -> Floats:
    """Return the covariances of intersections of two lines each, shape (n, 2, 2) [px²].

    The variance of a line's offset at the vertex is that at its middle plus that of its direction times the squared
    distance. Both offsets determine the vertex.

    Args:
        vertices: intersections, shape (n, 2) [px].
        middles: point of each line where its offset and direction are independent, shape (n, 2, 2) [px].
        directions: unit vectors of the lines, shape (n, 2, 2).
        variances: variances of the offset [px²] and of the direction [rad²] of each line, shape (n, 2, 2).
    """
    lever_arms = np.sum((vertices[:, None] - middles) * directions, axis=2)
    offsets = variances[..., 0] + lever_arms**2 * variances[..., 1]
    one, other = directions[:, 0], directions[:, 1]
    sines = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    # An offset of one line moves the vertex along the other line.
    along_other = other[:, :, None] * other[:, None, :] * offsets[:, :1, None]
    along_one = one[:, :, None] * one[:, None, :] * offsets[:, 1:, None]
    return np.asarray((along_other + along_one) / sines[:, None, None] ** 2, dtype=np.float64)


def intersect_with_covariance(one: RefinedLine, other: RefinedLine) -> tuple[Floats, Floats]:
    """Return the intersection of two lines, shape (2,) [px], and its covariance, shape (2, 2) [px²]."""
    vertex = intersect_lines(one, other)
    covariance = intersection_covariance(
        vertex[None],
        np.array([[one.middle, other.middle]]),
        np.array([[one.direction, other.direction]]),
        np.array([[one.variances, other.variances]]),
    )
    return vertex, covariance[0]


def intersect_lines(one: RefinedLine, other: RefinedLine) -> Floats:
    """Return the intersection of two lines, shape (2,) [px]."""
    along = np.linalg.solve(np.column_stack([one.direction, -other.direction]), other.middle - one.middle)
    return one.middle + along[0] * one.direction


def joint_corner_covariance(lines: list[RefinedLine], corners: Floats) -> Floats:
    """Return the joint covariance of all corners of a closed polygon of lines, shape (2 n, 2 n) [px²].

    Each line moves the two corners at its ends: equally by its offset, in proportion to the distance by its direction.

    Args:
        lines: the n lines in order.
        corners: corners, shape (n, 2) [px]; corner k is the intersection of lines k - 1 and k.
    """
    n = len(lines)
    covariance = np.zeros((2 * n, 2 * n))
    for k, line in enumerate(lines):
        motion = np.zeros((2 * n, 2))
        for corner, other in ((k, lines[k - 1]), ((k + 1) % n, lines[(k + 1) % n])):
            # The corner slides along the other line by the offset of this one.
            normal = np.array([-line.direction[1], line.direction[0]])
            slide = other.direction / (other.direction @ normal)
            along = (corners[corner] - line.middle) @ line.direction
            motion[2 * corner : 2 * corner + 2] = np.outer(slide, [1.0, along])
        covariance += motion * line.variances @ motion.T
    return covariance
