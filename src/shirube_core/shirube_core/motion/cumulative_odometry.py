"""Cumulative odometry: the pose and the running sums of its error model at one stamp."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class CumulativeOdometry(NamedTuple):
    """Odometry accumulated up to a stamp, in the buffer frame, which stays continuous when odometry restarts.

    The motion between any two stamps and its covariance are differences of these sums (docs/pose_arbiter.md).

    Attributes:
        stamp: stamp [ns].
        x, y, yaw: pose of the base in the buffer frame [m, rad].
        distance: distance driven [m].
        rotation: sum of the absolute yaw changes [rad].
        sx, sy, sxx, sxy, syy: sums over steps of s_k p_k and s_k p_k p_kᵀ (position p_k, distance and rotation s_k).
        odometry_gap: time without odometry [ns]; equals the stamp before the first message.
    """

    stamp: int
    x: float
    y: float
    yaw: float
    distance: float
    rotation: float
    sx: float
    sy: float
    sxx: float
    sxy: float
    syy: float
    odometry_gap: int

    def moved(self, twist: tuple[float, float, float], stamp: int, odometry_gap: int = 0) -> CumulativeOdometry:
        """Return the sums after one more step along the arc of a twist (see `SE2.exp`) until a stamp [ns]."""
        dx, dy, yaw = twist
        distance, rotation, half = math.hypot(dx, dy), abs(yaw), 0.5 * yaw
        chord = math.sin(half) / half if half else 1.0  # as in `SE2.exp`, without a pose on the way
        cos, sin = chord * math.cos(self.yaw + half), chord * math.sin(self.yaw + half)
        x, y, s = self.x + cos * dx - sin * dy, self.y + sin * dx + cos * dy, distance + rotation
        return CumulativeOdometry(
            stamp,
            x,
            y,
            self.yaw + yaw,
            self.distance + distance,
            self.rotation + rotation,
            self.sx + s * x,
            self.sy + s * y,
            self.sxx + s * x * x,
            self.sxy + s * x * y,
            self.syy + s * y * y,
            self.odometry_gap + odometry_gap,
        )


class Motion(NamedTuple):
    """Motion of the robot between two stamps, in the buffer frame.

    Attributes:
        x, y: displacement [m].
        yaw: yaw change [rad].
        distance: distance driven [m].
        rotation: sum of the absolute yaw changes [rad].
        odometry_gap: time without odometry [s].
        duration: time between the stamps [s].
    """

    x: float
    y: float
    yaw: float
    distance: float
    rotation: float
    odometry_gap: float
    duration: float

    def path_length(self, drift_speed: float) -> float:
        """Return the path length [m], with 1 rad as 1 m and the possible motion while there was no odometry."""
        return self.distance + self.rotation + drift_speed * self.odometry_gap


def motion_between(a: CumulativeOdometry, b: CumulativeOdometry) -> Motion:
    """Return the motion from a to the later b."""
    return Motion(
        b.x - a.x,
        b.y - a.y,
        math.remainder(b.yaw - a.yaw, math.tau),
        b.distance - a.distance,
        b.rotation - a.rotation,
        (b.odometry_gap - a.odometry_gap) * 1e-9,
        (b.stamp - a.stamp) * 1e-9,
    )


def motion_covariance(
    a: CumulativeOdometry, b: CumulativeOdometry, noise_xy: float, noise_yaw: float
) -> NDArray[np.float64]:
    """Return the covariance of (x, y, yaw), shape (3, 3), of the motion from a to b from the odometry noise alone.

    A yaw error e of step k at position p_k moves the end p by ``e J (p - p_k)``, J a rotation by 90°: the covariance
    is the sum of ``q s_k J (p - p_k)(p - p_k)ᵀ Jᵀ``, q the square of ``noise_yaw``.

    Args:
        a: cumulative odometry at the start.
        b: cumulative odometry at the end.
        noise_xy: standard deviation along x and y after 1 m [m].
        noise_yaw: standard deviation of the yaw after 1 m, and after 1 rad [rad].
    """
    x, y, distance, q = b.x, b.y, b.distance - a.distance, noise_yaw * noise_yaw
    s, sx, sy = distance + b.rotation - a.rotation, b.sx - a.sx, b.sy - a.sy
    rx, ry = s * x - sx, s * y - sy  # sum of s_k (p - p_k)
    rxx = x * rx - sx * x + (b.sxx - a.sxx)
    rxy = x * ry - sx * y + (b.sxy - a.sxy)
    ryy = y * ry - sy * y + (b.syy - a.syy)
    var_xy = noise_xy * noise_xy * distance
    xx, xy, xt, yy, yt = var_xy + q * ryy, -q * rxy, -q * ry, var_xy + q * rxx, q * rx
    return np.array(((xx, xy, xt), (xy, yy, yt), (xt, yt, q * s)))
