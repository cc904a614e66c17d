"""Cumulative odometry: the pose and the running sums of its error model at one stamp."""

from __future__ import annotations

import math
from typing import NamedTuple

from pose_arbiter.core.covariance import Covariance


class CumulativeOdometry(NamedTuple):
    """Odometry accumulated up to a stamp, in the buffer frame, which stays continuous when odometry restarts.

    The motion between any two stamps and its covariance are differences of these sums (docs/pose_arbiter.md).

    Attributes:
        stamp: stamp [ns].
        x, y, yaw: pose of the base in the buffer frame [m, rad].
        distance: distance driven [m].
        rotation: sum of the absolute yaw changes [rad].
        var_xy: sum of the variances of the steps along x and y [m²].
        q, qx, qy, qxx, qxy, qyy: sums over steps of q_k, q_k p_k and q_k p_k p_kᵀ (yaw variance q_k, position p_k).
        odometry_gap: time without odometry [ns]; equals the stamp before the first message.
    """

    stamp: int
    x: float
    y: float
    yaw: float
    distance: float
    rotation: float
    var_xy: float
    q: float
    qx: float
    qy: float
    qxx: float
    qxy: float
    qyy: float
    odometry_gap: int


class Motion(NamedTuple):
    """Motion of the robot between two stamps, in the buffer frame.

    Attributes:
        x, y: displacement [m].
        yaw: yaw change [rad].
        covariance: covariance of (x, y, yaw) from the odometry noise alone.
        distance: distance driven [m].
        rotation: sum of the absolute yaw changes [rad].
        odometry_gap: time without odometry [s].
        duration: time between the stamps [s].
    """

    x: float
    y: float
    yaw: float
    covariance: Covariance
    distance: float
    rotation: float
    odometry_gap: float
    duration: float

    def path_length(self, drift_speed: float) -> float:
        """Return the path length [m], with 1 rad as 1 m and the possible motion while there was no odometry."""
        return self.distance + self.rotation + drift_speed * self.odometry_gap


def motion_between(a: CumulativeOdometry, b: CumulativeOdometry) -> Motion:
    """Return the motion from a to the later b.

    A yaw variance q_k of step k at position p_k gives the end position p the covariance
    ``q_k J (p - p_k)(p - p_k)ᵀ Jᵀ``, J a rotation by 90°. The sum over the steps needs only differences of the sums.
    """
    q, x, y = b.q - a.q, b.x, b.y
    rx, ry = q * x - (b.qx - a.qx), q * y - (b.qy - a.qy)  # sum of q_k (p - p_k)
    rxx = x * rx - (b.qx - a.qx) * x + (b.qxx - a.qxx)
    ryy = y * ry - (b.qy - a.qy) * y + (b.qyy - a.qyy)
    rxy = x * ry - (b.qx - a.qx) * y + (b.qxy - a.qxy)
    var_xy = b.var_xy - a.var_xy
    covariance = (var_xy + ryy, -rxy, -ry, var_xy + rxx, rx, q)
    duration = (b.stamp - a.stamp) * 1e-9
    return Motion(
        x - a.x,
        y - a.y,
        math.remainder(b.yaw - a.yaw, math.tau),
        covariance,
        b.distance - a.distance,
        b.rotation - a.rotation,
        (b.odometry_gap - a.odometry_gap) * 1e-9,
        duration,
    )
