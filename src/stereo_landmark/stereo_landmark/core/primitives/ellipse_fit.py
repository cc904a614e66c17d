"""The direct least squares fit of an ellipse (Fitzgibbon et al. 1999, in the form of Halíř and Flusser 1998)."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, error_model='numpy')
def fit_ellipse(points: NDArray[np.float64], parameters: NDArray[np.float64]) -> bool:
    """Fit an ellipse to points of its outline and write its parameters.

    Args:
        points: shape (n, 2), at least five [px].
        parameters: shape (5,), filled with centre x, y, semi-axes a >= b [px] and tilt [rad].

    Returns:
        whether there is such an ellipse; not for points on a line.
    """
    n = len(points)
    mx, my = np.mean(points[:, 0]), np.mean(points[:, 1])
    scale = np.sqrt(np.mean((points[:, 0] - mx) ** 2 + (points[:, 1] - my) ** 2))
    if n < 5 or scale < 1e-9:
        return False
    s1, s2, s3 = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    quadratic, linear = np.empty(3), np.empty(3)
    for i in range(n):
        x, y = (points[i, 0] - mx) / scale, (points[i, 1] - my) / scale
        quadratic[0], quadratic[1], quadratic[2] = x * x, x * y, y * y
        linear[0], linear[1], linear[2] = x, y, 1.0
        for r in range(3):
            for c in range(3):
                s1[r, c] += quadratic[r] * quadratic[c]
                s2[r, c] += quadratic[r] * linear[c]
                s3[r, c] += linear[r] * linear[c]
    if abs(s3[0, 0] * s3[1, 1] - s3[0, 1] ** 2) < 1e-9 * n * n:
        return False
    to_linear = -np.linalg.solve(s3, s2.T.copy())
    m = s1 + s2 @ to_linear
    reduced = np.empty((3, 3))
    reduced[0], reduced[1], reduced[2] = 0.5 * m[2], -m[1], 0.5 * m[0]
    if not _elliptic_vector(reduced / n, quadratic):
        return False
    linear = to_linear @ quadratic
    if not _axes(quadratic, linear, parameters):
        return False
    parameters[:4] *= scale
    parameters[0] += mx
    parameters[1] += my
    return True


@njit(cache=True, error_model='numpy')
def _elliptic_vector(m: NDArray[np.float64], vector: NDArray[np.float64]) -> bool:
    """Write the eigenvector a, b, c of a 3 x 3 matrix with real eigenvalues for which 4 a c > b²."""
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    minors = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0] + m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]
    minors += m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    p = trace * trace / 9.0 - minors / 3.0
    if p <= 0.0:
        return False
    q = trace**3 / 27.0 - trace * minors / 6.0 + 0.5 * np.linalg.det(m)
    angle = np.arccos(min(max(q / p**1.5, -1.0), 1.0)) / 3.0
    for k in range(3):
        value = trace / 3.0 + 2.0 * np.sqrt(p) * np.cos(angle - 2.0 * np.pi * k / 3.0)
        rest = m - value * np.eye(3)
        longest = 0.0
        for r in range(3):
            null = np.cross(rest[r], rest[(r + 1) % 3])
            length = np.sum(null * null)
            if length > longest:
                longest = length
                vector[:] = null / np.sqrt(length)
        if longest > 0.0 and 4.0 * vector[0] * vector[2] > vector[1] ** 2:
            return True
    return False


@njit(cache=True, error_model='numpy')
def _axes(
    quadratic: NDArray[np.float64], linear: NDArray[np.float64], parameters: NDArray[np.float64]
) -> bool:
    """Turn a x² + b xy + c y² + d x + e y + f = 0 into centre, axes and tilt."""
    a, b, c = quadratic
    d, e, f = linear
    determinant = 4.0 * a * c - b * b
    x, y = (b * e - 2.0 * c * d) / determinant, (b * d - 2.0 * a * e) / determinant
    level = -(f + 0.5 * (d * x + e * y))
    half, twist = 0.5 * (a + c), np.hypot(0.5 * (a - c), 0.5 * b)
    if level < 0.0:
        a, b, c, level, half = -a, -b, -c, -level, -half
    if half - twist <= 0.0 or level <= 0.0:
        return False
    # The long axis has the smaller curvature.
    tilt = 0.5 * np.arctan2(-b, c - a)
    parameters[0], parameters[1] = x, y
    parameters[2], parameters[3] = np.sqrt(level / (half - twist)), np.sqrt(level / (half + twist))
    parameters[4] = tilt
    return True
