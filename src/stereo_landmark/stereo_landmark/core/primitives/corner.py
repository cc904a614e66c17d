"""Corners: two straight arms that intersect at a vertex (paper 3.3c)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage, Ints
from stereo_landmark.core.primitives.corner_links import (
    intersect_with_covariance,
    intersection_covariance,
    link_corners,
)
from stereo_landmark.core.primitives.line_refinement import refine_lines
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

    angle: float = setting(0.35, 'tolerance of the angle', unit='rad', minimum=0.01, maximum=1.5)
    bisector: float = setting(0.35, 'tolerance of the bisector', unit='rad', minimum=0.01, maximum=3.2)


def corner_differences(found: Floats, taught: Floats, tolerance: CornerTolerance) -> Floats:
    """Return the differences of detected from taught shape vectors, shape (k, n); arm lengths do not count.

    Args:
        found: shape vectors of the detected corners, shape (n, 3).
        taught: shape vectors of the taught corners, shape (k, 3).
        tolerance: tolerances, at which the difference is 1.
    """
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    angles = np.abs(mine[0] - theirs[0]) / tolerance.angle
    bisectors = np.abs(wrap_differences(mine[1] - theirs[1], 2.0 * math.pi)) / tolerance.bisector
    return np.where(mine[2] == theirs[2], np.maximum(angles, bisectors), math.inf)


def detect_corners(lines: LineSegments, settings: PrimitiveSettings) -> LazyShapes[Corner]:
    """Detect the corners of intersecting line segments.

    Args:
        lines: line segments of the image.
        settings: detection settings.

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
        np.array(
            [
                (arm_end - vertex) @ arm.direction
                for arm_end, arm in zip(arm_ends, (first, second), strict=True)
            ]
        ),
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
