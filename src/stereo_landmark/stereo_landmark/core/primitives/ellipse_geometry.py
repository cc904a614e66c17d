"""Geometry of an ellipse: points, normals, foot points, perimeter, and Jacobians by its parameters."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, error_model='numpy')
def ellipse_point(parameters: NDArray[np.float64], t: float) -> tuple[float, float, float, float, float]:
    """Return a point of the ellipse, its outward unit normal and the speed |dP/dt|.

    Args:
        parameters: centre x, y, semi-axes a, b [px], tilt [rad], shape (5,).
        t: curve parameter in c + R(tilt) (a cos t, b sin t) [rad].

    Returns:
        x, y [px], normal x, y, speed [px / rad].
    """
    cx, cy, a, b, tilt = parameters
    cos_t, sin_t, cos_r, sin_r = np.cos(t), np.sin(t), np.cos(tilt), np.sin(tilt)
    speed = np.sqrt((a * sin_t) ** 2 + (b * cos_t) ** 2)
    px, py, nx, ny = a * cos_t, b * sin_t, b * cos_t / speed, a * sin_t / speed
    return (
        cx + cos_r * px - sin_r * py,
        cy + sin_r * px + cos_r * py,
        cos_r * nx - sin_r * ny,
        sin_r * nx + cos_r * ny,
        speed,
    )


@njit(cache=True, error_model='numpy')
def normal_jacobian_row(parameters: NDArray[np.float64], t: float, row: NDArray[np.float64]) -> None:
    """Write the derivatives of the outline's position along its normal by the parameters, shape (5,)."""
    a, b = parameters[2], parameters[3]
    _, _, nx, ny, speed = ellipse_point(parameters, t)
    cos_t, sin_t = np.cos(t), np.sin(t)
    row[0], row[1] = nx, ny
    row[2] = b * cos_t * cos_t / speed
    row[3] = a * sin_t * sin_t / speed
    row[4] = (a * a - b * b) * sin_t * cos_t / speed


@njit(cache=True, error_model='numpy')
def normal_jacobian(parameters: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return the rows of `normal_jacobian_row` at ``count`` evenly spaced curve parameters, shape (count, 5)."""
    rows = np.empty((count, 5))
    for k in range(count):
        normal_jacobian_row(parameters, 2.0 * np.pi * k / count, rows[k])
    return rows


@njit(cache=True, error_model='numpy')
def foot_point(a: float, b: float, u: float, v: float) -> tuple[float, float, float]:
    """Return cosine and sine of the curve parameter of the nearest point of the outline, and the speed |dP/dt| there.

    Args:
        a: semi-axis along u [px].
        b: semi-axis along v [px].
        u: coordinate of a point near the outline, along the first axis of the ellipse [px].
        v: coordinate of the point along the second axis [px].
    """
    cos_t, sin_t = u * b, v * a
    norm = np.sqrt(cos_t * cos_t + sin_t * sin_t)
    cos_t, sin_t = (cos_t / norm, sin_t / norm) if norm > 0.0 else (1.0, 0.0)
    for _ in range(3):
        # Newton's method on (P - Q) . dP/dt = 0; the small rotation avoids trigonometric functions.
        dx, dy = a * cos_t - u, b * sin_t - v
        slope = dy * b * cos_t - dx * a * sin_t
        bend = (a * sin_t) ** 2 + (b * cos_t) ** 2 - dx * a * cos_t - dy * b * sin_t
        if bend > 0.0:
            turn = -slope / bend
            cos_t, sin_t = cos_t - turn * sin_t, sin_t + turn * cos_t
            norm = np.sqrt(1.0 + turn * turn)
            cos_t, sin_t = cos_t / norm, sin_t / norm
    return cos_t, sin_t, np.sqrt((a * sin_t) ** 2 + (b * cos_t) ** 2)


@njit(cache=True, error_model='numpy')
def perimeter(a: float, b: float) -> float:
    """Return the perimeter of an ellipse by Ramanujan's second formula [px]."""
    h = ((a - b) / (a + b)) ** 2
    return np.pi * (a + b) * (1.0 + 3.0 * h / (10.0 + np.sqrt(4.0 - 3.0 * h)))
