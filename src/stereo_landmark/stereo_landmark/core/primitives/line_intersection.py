"""Intersections of lines and their covariances."""

from __future__ import annotations

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.primitives.line_refinement import RefinedLine


def intersection_covariance(
    vertices: Floats, middles: Floats, directions: Floats, variances: Floats
) -> Floats:
    """Return the covariances of intersections of two lines each, shape (n, 2, 2) [px²].

    The offset of each line at the vertex has the variance of its offset at its middle plus that of its direction
    times the squared distance. Both offsets determine the vertex.

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
