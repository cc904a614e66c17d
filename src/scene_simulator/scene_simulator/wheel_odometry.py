"""What a differential drive's encoders make of a drive: ticks, wrong radii, slip, and drift that follows."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose


@dataclass(frozen=True)
class WheelErrors:
    """A drive and its errors. The default drifts by about 2 % of the way and 1 degree a metre.

    Attributes:
        separation: distance between the wheels [m].
        tick: way of a wheel between two encoder ticks [m].
        left_scale: measured way of the left wheel relative to the true way.
        right_scale: the same of the right wheel.
        slip: standard deviation of a wheel's way after one metre [m]; it grows with the root of the way.
    """

    separation: float = 0.3
    tick: float = 0.00008
    left_scale: float = 1.0174
    right_scale: float = 1.0226
    slip: float = 0.001


@dataclass(frozen=True)
class WheelReading:
    """A reading of the wheel odometry.

    Attributes:
        time: [s].
        pose: ``T_odom_base``.
        forward: speed since the last reading [m/s].
        turn: turn rate since then [rad/s].
    """

    time: float
    pose: PlanarPose
    forward: float
    turn: float


def read_wheels(
    pose_at: Callable[[float], PlanarPose],
    seconds: float,
    period: float,
    errors: WheelErrors,
    rng: np.random.Generator,
) -> list[WheelReading]:
    """Return the readings of the first seconds of a drive.

    Args:
        pose_at: gives ``T_map_base`` at a time [s].
        seconds: how long the wheels are read [s].
        period: between two readings [s].
        errors: the drive's errors.
        rng: source of the slip.
    """
    times = np.arange(0.0, seconds, period).tolist()
    poses = measure_odometry([pose_at(time) for time in times], errors, rng)
    steps = [before.inverse() @ after for before, after in zip([poses[0], *poses], poses, strict=False)]
    return [
        WheelReading(time, pose, step.x / period, step.yaw / period)
        for time, pose, step in zip(times, poses, steps, strict=True)
    ]


def measure_odometry(
    poses: Sequence[PlanarPose], errors: WheelErrors, rng: np.random.Generator
) -> list[PlanarPose]:
    """Return the odometry of a drive.

    Args:
        poses: ``T_map_base`` at the instants at which the encoders are read; little motion between two.
        errors: the drive's errors.
        rng: source of the slip.

    Returns:
        ``T_odom_base`` at the same instants, the first one zero.
    """
    scales = np.array([errors.left_scale, errors.right_scale])
    ways = ticks = np.zeros(2)
    odometry = [PlanarPose(0.0, 0.0, 0.0)]
    for before, after in pairwise(poses):
        true_ways = _wheel_ways(before.inverse() @ after, errors.separation)
        ways = ways + scales * true_ways + rng.normal(size=2) * errors.slip * np.sqrt(np.abs(true_ways))
        read = np.floor(ways / errors.tick)
        left, right = (float(way) for way in (read - ticks) * errors.tick)
        ticks = read
        odometry.append(odometry[-1] @ _motion(left, right, errors.separation))
    return odometry


def _wheel_ways(motion: PlanarPose, separation: float) -> NDArray[np.float64]:
    """Return how far the left and the right wheel roll in a motion along an arc, shape (2,) [m]."""
    half = 0.5 * motion.yaw
    way = math.hypot(motion.x, motion.y) * math.copysign(1.0, motion.x) / np.sinc(half / math.pi)
    return np.array([way - half * separation, way + half * separation])


def _motion(left: float, right: float, separation: float) -> PlanarPose:
    """Return the motion along the arc on which the wheels roll so far [m]."""
    way, turn = 0.5 * (left + right), (right - left) / separation
    chord = way * float(np.sinc(0.5 * turn / math.pi))
    return PlanarPose(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn)
