"""Covariances of (x, y, yaw) as six floats, which are many times faster than arrays of nine.

The order is xx, xy, xt, yy, yt, tt, where t is yaw [m², m rad, rad²].
"""

from __future__ import annotations

import math

Covariance = tuple[float, float, float, float, float, float]
Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


def diagonal(var_xy: float, var_yaw: float) -> Covariance:
    """Return a covariance that is the same along x and y [m²] and has no correlations."""
    return (var_xy, 0.0, 0.0, var_xy, 0.0, var_yaw)


def added(a: Covariance, b: Covariance) -> Covariance:
    """Return the sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


def scaled(a: Covariance, factor: float) -> Covariance:
    """Return a multiple."""
    return (a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor, a[4] * factor, a[5] * factor)


def turned(a: Covariance, cos: float, sin: float) -> Covariance:
    """Return ``R a Rᵀ`` for a turn of the plane about the z axis."""
    xx, xy, xt, yy, yt, tt = a
    along, across = cos * xx - sin * xy, cos * xy - sin * yy
    up, over = sin * xx + cos * xy, sin * xy + cos * yy
    return (
        along * cos - across * sin,
        along * sin + across * cos,
        cos * xt - sin * yt,
        up * sin + over * cos,
        sin * xt + cos * yt,
        tt,
    )


def levered(a: Covariance, lever_x: float, lever_y: float) -> Covariance:
    """Return ``F a Fᵀ`` with ``F = [1 0 -lever_y; 0 1 lever_x; 0 0 1]``: what a wrong heading does over a way [m]."""
    xx, xy, xt, yy, yt, tt = a
    new_xt, new_yt = xt - lever_y * tt, yt + lever_x * tt
    return (
        xx - lever_y * (xt + new_xt),
        xy + lever_x * xt - lever_y * new_yt,
        new_xt,
        yy + lever_x * (yt + new_yt),
        new_yt,
        tt,
    )


def inverse(a: Covariance) -> Covariance:
    """Return the inverse of a positive definite covariance (by its adjugate)."""
    xx, xy, xt, yy, yt, tt = a
    c0, c1, c2 = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    scale = 1.0 / (xx * c0 + xy * c1 + xt * c2)
    return (
        c0 * scale,
        c1 * scale,
        c2 * scale,
        (xx * tt - xt * xt) * scale,
        (xy * xt - xx * yt) * scale,
        (xx * yy - xy * xy) * scale,
    )


def product(a: Covariance, b: Covariance) -> Matrix:
    """Return the matrix ``a b``."""
    axx, axy, axt, ayy, ayt, att = a
    bxx, bxy, bxt, byy, byt, btt = b
    return (
        (
            axx * bxx + axy * bxy + axt * bxt,
            axx * bxy + axy * byy + axt * byt,
            axx * bxt + axy * byt + axt * btt,
        ),
        (
            axy * bxx + ayy * bxy + ayt * bxt,
            axy * bxy + ayy * byy + ayt * byt,
            axy * bxt + ayy * byt + ayt * btt,
        ),
        (
            axt * bxx + ayt * bxy + att * bxt,
            axt * bxy + ayt * byy + att * byt,
            axt * bxt + ayt * byt + att * btt,
        ),
    )


def conjugated(m: Matrix, a: Covariance) -> Covariance:
    """Return ``m a mᵀ``."""
    rows = []
    for p, q, r in m:
        rows.append(
            (
                p * a[0] + q * a[1] + r * a[2],
                p * a[1] + q * a[3] + r * a[4],
                p * a[2] + q * a[4] + r * a[5],
            )
        )
    (f, g, h), (k, l, n), (u, v, w) = rows
    (_, _, _), (bx, by, bz), (cx, cy, cz) = m
    ax, ay, az = m[0]
    return (
        f * ax + g * ay + h * az,
        f * bx + g * by + h * bz,
        f * cx + g * cy + h * cz,
        k * bx + l * by + n * bz,
        k * cx + l * cy + n * cz,
        u * cx + v * cy + w * cz,
    )


def distance_squared(residual: Vector, information: Covariance) -> float:
    """Return the squared Mahalanobis distance of a residual, ``information`` being an inverse covariance."""
    x, y, t = residual
    xx, xy, xt, yy, yt, tt = information
    return x * (xx * x + 2.0 * (xy * y + xt * t)) + y * (yy * y + 2.0 * yt * t) + tt * t * t


def is_positive_definite(a: Covariance) -> bool:
    """Return whether all numbers are finite and every leading minor is above zero."""
    xx, xy, xt, yy, yt, tt = a
    if not all(map(math.isfinite, a)):
        return False
    minor = xx * yy - xy * xy
    whole = xx * (yy * tt - yt * yt) - xy * (xy * tt - xt * yt) + xt * (xy * yt - xt * yy)
    return xx > 0.0 and minor > 0.0 and whole > 0.0
