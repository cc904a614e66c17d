"""Cumulative odometry: the pose and the running sums of its error model at one stamp."""

from __future__ import annotations

import math
from typing import NamedTuple


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

    def moved(
        self, twist: tuple[float, float, float], stamp: int, odometry_gap: int = 0
    ) -> CumulativeOdometry:
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
        rx, ry, rxx, rxy, ryy: sums over the steps of s_k r_k and s_k r_k r_kᵀ, r_k from the step to the end.
        odometry_gap: time without odometry [s].
        duration: time between the stamps [s].
    """

    x: float
    y: float
    yaw: float
    distance: float
    rotation: float
    rx: float
    ry: float
    rxx: float
    rxy: float
    ryy: float
    odometry_gap: float
    duration: float

    def covariance(
        self, noise_xy: float, noise_yaw: float
    ) -> tuple[float, float, float, float, float, float]:
        """Return the covariance (xx, xy, xt, yy, yt, tt) of (x, y, yaw) from the odometry noise alone.

        A yaw error e of step k moves the end by e J r_k, J a rotation by 90°: the covariance is the sum of
        ``q s_k J r_k r_kᵀ Jᵀ``, q the square of ``noise_yaw``.

        Args:
            noise_xy: standard deviation along x and y after 1 m [m].
            noise_yaw: standard deviation of the yaw after 1 m, and after 1 rad [rad].
        """
        var_xy, q = noise_xy**2 * self.distance, noise_yaw**2
        var_yaw = q * (self.distance + self.rotation)
        return (
            var_xy + q * self.ryy,
            -q * self.rxy,
            -q * self.ry,
            var_xy + q * self.rxx,
            q * self.rx,
            var_yaw,
        )

    def path_length(self, drift_speed: float) -> float:
        """Return the path length [m], with 1 rad as 1 m and the possible motion while there was no odometry."""
        return self.distance + self.rotation + drift_speed * self.odometry_gap


def motion_between(a: CumulativeOdometry, b: CumulativeOdometry) -> Motion:
    """Return the motion from a to the later b."""
    x, y = b.x, b.y
    distance, rotation = b.distance - a.distance, b.rotation - a.rotation
    s, sx, sy = distance + rotation, b.sx - a.sx, b.sy - a.sy
    rx, ry = s * x - sx, s * y - sy  # sum of s_k (p - p_k)
    return Motion(
        x - a.x,
        y - a.y,
        math.remainder(b.yaw - a.yaw, math.tau),
        distance,
        rotation,
        rx,
        ry,
        x * rx - sx * x + (b.sxx - a.sxx),
        x * ry - sx * y + (b.sxy - a.sxy),
        y * ry - sy * y + (b.syy - a.syy),
        (b.odometry_gap - a.odometry_gap) * 1e-9,
        (b.stamp - a.stamp) * 1e-9,
    )
