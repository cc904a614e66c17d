"""Simulated wheel odometry of a differential drive: encoder ticks, wheel scale errors, slip and drift."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scene_simulator.robot.leg_drive import arc_motion
from shirube_core.geometry import SE2


@dataclass(frozen=True)
class WheelErrors:
    """A drive and its errors. The default drifts by about 2 % of the distance and 1 degree a metre.

    Attributes:
        separation: distance between the wheels [m].
        tick: wheel travel per encoder tick [m].
        left_scale: measured travel of the left wheel relative to the true travel.
        right_scale: the same of the right wheel.
        slip: standard deviation of a wheel's travel after one metre [m]; it grows with the square root of the distance.
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
        forward: mean speed since the last reading [m/s].
        yaw_rate: mean yaw rate since the last reading [rad/s].
    """

    time: float
    pose: SE2
    forward: float
    yaw_rate: float


def simulate_wheel_readings(
    pose_at: Callable[[float], SE2], seconds: float, period: float, errors: WheelErrors, rng: np.random.Generator
) -> list[WheelReading]:
    """Return the readings of the first seconds of a drive, one each period [s]; ``pose_at`` gives ``T_map_base``."""
    times = np.arange(0.0, seconds, period).tolist()
    poses = simulate_odometry([pose_at(time) for time in times], errors, rng)
    steps = [before.inverse() @ after for before, after in zip([poses[0], *poses], poses, strict=False)]
    return [
        WheelReading(time, pose, step.x / period, step.yaw / period)
        for time, pose, step in zip(times, poses, steps, strict=True)
    ]


def simulate_odometry(poses: Sequence[SE2], errors: WheelErrors, rng: np.random.Generator) -> list[SE2]:
    """Return ``T_odom_base``, the first one zero, at the instants at which the encoders are read.

    There is little motion between two true poses ``T_map_base``; the source of randomness is that of the slip.
    """
    scales = np.array([errors.left_scale, errors.right_scale])
    ways = ticks = np.zeros(2)
    odometry = [SE2(0.0, 0.0, 0.0)]
    for before, after in pairwise(poses):
        true_ways = _wheel_distances(before.inverse() @ after, errors.separation)
        ways = ways + scales * true_ways + rng.normal(size=2) * errors.slip * np.sqrt(np.abs(true_ways))
        read = np.floor(ways / errors.tick)
        left, right = (float(way) for way in (read - ticks) * errors.tick)
        ticks = read
        odometry.append(odometry[-1] @ arc_motion(0.5 * (left + right), (right - left) / errors.separation))
    return odometry


def _wheel_distances(motion: SE2, separation: float) -> NDArray[np.float64]:
    """Return how far the left and the right wheel roll in a motion along an arc, shape (2,) [m]."""
    half = 0.5 * motion.yaw
    way = math.hypot(motion.x, motion.y) * math.copysign(1.0, motion.x) / np.sinc(half / math.pi)
    return np.array([way - half * separation, way + half * separation])
