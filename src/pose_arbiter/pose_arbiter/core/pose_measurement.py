"""Pose measurements, and the consistency test of two of them by odometry."""

from __future__ import annotations

import math
from typing import NamedTuple

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import Covariance
from shirube_core.motion import CumulativeOdometry, motion_between


class PoseMeasurement(NamedTuple):
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


class PoseWithOdometry(NamedTuple):
    """A measured pose with the odometry at its stamp.

    Attributes:
        odometry: cumulative odometry at its stamp.
        x, y, yaw: ``T_map_base`` [m, rad].
        var_xy, var_yaw: larger of the variances of x and y [m²], and variance of yaw [rad²].
    """

    odometry: CumulativeOdometry
    x: float
    y: float
    yaw: float
    var_xy: float
    var_yaw: float


def attach_odometry(measurement: PoseMeasurement, odometry: CumulativeOdometry) -> PoseWithOdometry:
    """Return a measurement with the odometry at its stamp."""
    _, _, x, y, yaw, noise = measurement
    return PoseWithOdometry(odometry, x, y, yaw, max(noise[0], noise[3]), noise[5])


def is_consistent(a: PoseWithOdometry, b: PoseWithOdometry, gate: float, settings: ArbiterSettings) -> bool:
    """Return whether odometry leads from a to b, within their variances and the odometry errors (chi-square gate).

    For yaw, both the systematic and the random odometry error count; the random one is larger over a short distance.
    For distance only the systematic one counts, so that a frozen source is detected even when the robot moves slowly.
    """
    if b.odometry.stamp < a.odometry.stamp:
        a, b = b, a
    motion = motion_between(a.odometry, b.odometry)
    yaw_offset = a.yaw - a.odometry.yaw
    cos, sin = math.cos(yaw_offset), math.sin(yaw_offset)
    x = b.x - a.x - cos * motion.x + sin * motion.y
    y = b.y - a.y - sin * motion.x - cos * motion.y
    yaw = math.remainder(b.yaw - a.yaw - motion.yaw, math.tau)
    chord_squared = motion.x * motion.x + motion.y * motion.y
    path_length = motion.distance + motion.rotation
    yaw_bias = settings.odometry_bias * path_length
    yaw_noise_var = settings.odometry_noise_yaw**2 * path_length
    yaw_bias_var = yaw_bias * yaw_bias + (settings.drift_turn_rate * motion.odometry_gap) ** 2
    var_yaw = a.var_yaw + b.var_yaw + settings.gate_margin_yaw**2 + yaw_bias_var + yaw_noise_var
    var_xy = (
        a.var_xy
        + b.var_xy
        + settings.gate_margin_xy**2
        + (settings.odometry_bias * motion.distance) ** 2
        + (settings.drift_speed * motion.odometry_gap) ** 2
        + chord_squared * (a.var_yaw + yaw_bias_var)
    )
    return (x * x + y * y) / var_xy + yaw * yaw / var_yaw <= gate
