"""A short simulated drive with wrong odometry and several sources."""

import math
import random

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from shirube_core.geometry import SE2

SECOND = 1_000_000_000
BEGIN = 1000 * SECOND
ODOMETRY = 'odometry'
SIGMA = 0.005


def true_pose(seconds):
    """Return the pose on a circle of 1 m radius, at 0.4 m/s."""
    angle = 0.4 * seconds
    return SE2(math.sin(angle), 1.0 - math.cos(angle), math.remainder(angle, math.tau))


def odometry_pose(seconds):
    """Return odometry with a scale error of 2 %, from another origin."""
    angle = 0.4 * seconds
    away = SE2(3.0, -2.0, 1.0)
    return away @ SE2(1.02 * math.sin(angle), 1.02 * (1.0 - math.cos(angle)), angle)


def shift_pose(pose, x=0.0, y=0.0, yaw=0.0):
    return SE2(pose.x + x, pose.y + y, pose.yaw + yaw)


def messages(seconds, sources, begin=0.0, rate=20.0, odometry_rate=50.0):
    """Return (stamp, source, pose) in order; each source maps seconds to a pose, None where it is silent."""
    times = [begin + k / odometry_rate for k in range(round(seconds * odometry_rate) + 1)]
    said = [(BEGIN + round(at * SECOND), ODOMETRY, odometry_pose(at)) for at in times]
    for number, source in enumerate(sources):
        for k in range(round(seconds * rate)):
            at = begin + (k + 0.3 * number) / rate + 0.003
            pose = source(at)
            if pose is not None:
                said.append((BEGIN + round(at * SECOND), number, pose))
    return sorted(said, key=lambda m: m[0])


def noisy(seed, sigma=SIGMA, pose_at=true_pose):
    rng = random.Random(seed)

    def look(seconds):
        return shift_pose(pose_at(seconds), *(rng.gauss(0.0, 0.7 * sigma) for _ in range(3)))

    return look


def new_arbiter(count, sources=None, **settings):
    sources = sources or [SourceSettings(sigma_xy=SIGMA, sigma_yaw=SIGMA)] * count
    return Arbiter(sources, ArbiterSettings(**settings))


def add_messages(arbiter, said, now=None):
    for stamp, source, pose in said:
        at = stamp if now is None else now
        if source == ODOMETRY:
            assert arbiter.add_odometry(stamp, pose, at) is None
        else:
            assert arbiter.add_pose(source, stamp, pose, None, at) is None


def errors(arbiter, seconds):
    """Return the errors of the fused pose in position [m] and yaw [rad]."""
    estimate = arbiter.estimate_at(BEGIN + round(seconds * SECOND))
    pose, true = SE2(estimate.x, estimate.y, estimate.yaw), true_pose(seconds)
    return pose.distance_to(true), abs(pose.yaw_to(true))


def numbers(estimate):
    """All numbers of an estimate."""
    arrays = (estimate.bias, estimate.bias_sigmas, estimate.P)
    return [*estimate.odometry, *estimate[1:4], *(x for array in arrays for x in array.ravel())]
