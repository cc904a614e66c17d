"""Where odometry stood at an instant, and what it has summed up until then."""

from __future__ import annotations

import math
from typing import NamedTuple

from pose_arbiter.core.covariance import Covariance


class OdometryMark(NamedTuple):
    """An instant of the odometry, in a frame of its own (``trail``) that no restart of the wheels' frame breaks.

    The sums make the covariance of a motion between any two marks a matter of differences (docs/pose_arbiter.md).

    Attributes:
        stamp: [ns].
        x, y, yaw: pose of the base in ``trail`` [m, rad].
        way: driven until then [m].
        turn: turned until then, without sign [rad].
        spread: sum of the variances of the steps along x and y [m²].
        q, qx, qy, qxx, qxy, qyy: sums of the variances of the steps' turns, times the place of each step.
        blind: time without odometry until then [ns]; counts from 0 before the first.
    """

    stamp: int
    x: float
    y: float
    yaw: float
    way: float
    turn: float
    spread: float
    q: float
    qx: float
    qy: float
    qxx: float
    qxy: float
    qyy: float
    blind: int


class Motion(NamedTuple):
    """How the robot moved between two marks, in ``trail``.

    Attributes:
        x, y: way [m].
        yaw: turn [rad].
        covariance: of (x, y, yaw), from the steps of odometry alone.
        way: length driven [m].
        turn: without sign [rad].
        blind: time without odometry [s].
        seconds: between the marks [s].
    """

    x: float
    y: float
    yaw: float
    covariance: Covariance
    way: float
    turn: float
    blind: float
    seconds: float

    def moved(self, drift_speed: float) -> float:
        """Return the way [m], a radian counting as 1 m, with what may have been driven while there was no odometry."""
        return self.way + self.turn + drift_speed * self.blind


def motion_between(a: OdometryMark, b: OdometryMark) -> Motion:
    """Return the motion from mark a to the later mark b.

    With the heading of step k wrong by a variance q_k at the place p_k, the end p is wrong by
    ``q_k J (p - p_k)(p - p_k)ᵀ Jᵀ``, J a quarter turn. Their sum over the steps needs only differences of the sums.
    """
    q, x, y = b.q - a.q, b.x, b.y
    rx, ry = q * x - (b.qx - a.qx), q * y - (b.qy - a.qy)  # sum of q_k (p - p_k)
    rxx = x * rx - (b.qx - a.qx) * x + (b.qxx - a.qxx)
    ryy = y * ry - (b.qy - a.qy) * y + (b.qyy - a.qyy)
    rxy = x * ry - (b.qx - a.qx) * y + (b.qxy - a.qxy)
    spread = b.spread - a.spread
    covariance = (spread + ryy, -rxy, -ry, spread + rxx, rx, q)
    seconds = (b.stamp - a.stamp) * 1e-9
    return Motion(
        x - a.x,
        y - a.y,
        math.remainder(b.yaw - a.yaw, math.tau),
        covariance,
        b.way - a.way,
        b.turn - a.turn,
        (b.blind - a.blind) * 1e-9,
        seconds,
    )
