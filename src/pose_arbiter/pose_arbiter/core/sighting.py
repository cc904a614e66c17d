"""Pose measurements, and the consistency test of two of them by odometry."""

from __future__ import annotations

import math
from typing import NamedTuple

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import Covariance
from pose_arbiter.core.odometry_mark import OdometryMark, motion_between


class Observation(NamedTuple):
    """A measured pose. Measurements are processed in the sort order of this tuple.

    Attributes:
        stamp: stamp [ns].
        source: source index; -1 is a pose set by an operator.
        x, y, yaw: ``T_map_base`` [m, rad].
        noise: covariance R of the measurement.
    """

    stamp: int
    source: int
    x: float
    y: float
    yaw: float
    noise: Covariance


class Sighting(NamedTuple):
    """A measured pose with the odometry at its stamp.

    Attributes:
        odometry: cumulative odometry at its stamp.
        x, y, yaw: ``T_map_base`` [m, rad].
        var_xy, var_yaw: larger of the variances of x and y [m²], and variance of yaw [rad²].
    """

    mark: OdometryMark
    x: float
    y: float
    yaw: float
    var_xy: float
    var_yaw: float


def sighting_of(observation: Observation, mark: OdometryMark) -> Sighting:
    """Return a measurement with the odometry at its stamp."""
    _, _, x, y, yaw, noise = observation
    return Sighting(mark, x, y, yaw, max(noise[0], noise[3]), noise[5])


def same_robot(a: Sighting, b: Sighting, gate: float, settings: ArbiterSettings) -> bool:
    """Return whether odometry leads from a to b, within their variances and the odometry errors (chi-square gate).

    For yaw, both the systematic and the random odometry error count; the random one is larger over a short distance.
    For distance only the systematic one counts, so that a frozen source is detected even when the robot moves slowly.
    """
    if b.mark.stamp < a.mark.stamp:
        a, b = b, a
    motion = motion_between(a.mark, b.mark)
    between = a.yaw - a.mark.yaw
    cos, sin = math.cos(between), math.sin(between)
    x = b.x - a.x - cos * motion.x + sin * motion.y
    y = b.y - a.y - sin * motion.x - cos * motion.y
    yaw = math.remainder(b.yaw - a.yaw - motion.yaw, math.tau)
    chord2 = motion.x * motion.x + motion.y * motion.y
    swept = settings.way_bias * (motion.way + motion.turn)
    turn_var = swept * swept + (settings.drift_turn_rate * motion.blind) ** 2
    var_yaw = a.var_yaw + b.var_yaw + settings.slack_yaw**2 + turn_var + motion.covariance[5]
    var_xy = (
        a.var_xy
        + b.var_xy
        + settings.slack_xy**2
        + (settings.way_bias * motion.way) ** 2
        + (settings.drift_speed * motion.blind) ** 2
        + chord2 * (a.var_yaw + turn_var)
    )
    return (x * x + y * y) / var_xy + yaw * yaw / var_yaw <= gate
