"""Where two lines meet, and how well that is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.line_refinement import RefinedLine


def crossing_covariance(
    vertices: NDArray[np.float64],
    middles: NDArray[np.float64],
    directions: NDArray[np.float64],
    variances: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the covariances of crossings of two lines each, shape (n, 2, 2) [px²].

    Each line is known across itself at its middle and by its direction: at the vertex its offset has the
    variance of both together, and the two offsets give the place.

    Args:
        vertices: shape (n, 2) [px].
        middles: shape (n, 2, 2), a point of each line where its offset and direction are independent [px].
        directions: shape (n, 2, 2), unit vectors.
        variances: shape (n, 2, 2), of the offset [px²] and of the direction [rad²] of each line.
    """
    arms = np.sum((vertices[:, None] - middles) * directions, axis=2)
    offsets = variances[..., 0] + arms**2 * variances[..., 1]
    one, other = directions[:, 0], directions[:, 1]
    sines = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    # An offset of one line moves the vertex along the other one.
    along_other = other[:, :, None] * other[:, None, :] * offsets[:, :1, None]
    along_one = one[:, :, None] * one[:, None, :] * offsets[:, 1:, None]
    return np.asarray((along_other + along_one) / sines[:, None, None] ** 2, dtype=np.float64)


def crossing_of(one: RefinedLine, other: RefinedLine) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where two lines meet, shape (2,) [px], and the covariance, shape (2, 2) [px²]."""
    vertex = meeting_point(one, other)
    covariance = crossing_covariance(
        vertex[None],
        np.array([[one.middle, other.middle]]),
        np.array([[one.direction, other.direction]]),
        np.array([[one.variances, other.variances]]),
    )
    return vertex, covariance[0]


def meeting_point(one: RefinedLine, other: RefinedLine) -> NDArray[np.float64]:
    """Return where two lines meet, shape (2,) [px]."""
    along = np.linalg.solve(np.column_stack([one.direction, -other.direction]), other.middle - one.middle)
    return one.middle + along[0] * one.direction


def joint_covariance(lines: list[RefinedLine], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance of all corners of a ring of lines, shape (2 n, 2 n) [px²].

    Each line moves the two corners at its ends: by its offset alike, by its direction the more the farther.

    Args:
        lines: the n lines in order.
        corners: shape (n, 2), corner k where line k - 1 meets line k [px].
    """
    n = len(lines)
    covariance = np.zeros((2 * n, 2 * n))
    for k, line in enumerate(lines):
        motion = np.zeros((2 * n, 2))
        for corner, other in ((k, lines[k - 1]), ((k + 1) % n, lines[(k + 1) % n])):
            # The corner slides along the other line until its offset from this one is the asked one.
            normal = np.array([-line.direction[1], line.direction[0]])
            slide = other.direction / (other.direction @ normal)
            along = (corners[corner] - line.middle) @ line.direction
            motion[2 * corner : 2 * corner + 2] = np.outer(slide, [1.0, along])
        covariance += motion * line.variances @ motion.T
    return covariance
