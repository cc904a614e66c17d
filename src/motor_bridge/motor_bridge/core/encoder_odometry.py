"""Odometry and joint states from checked encoder counts."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.count_watch import CountVerdict, CountWatch, turns_between
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.serial_protocol import WheelCounts
from motor_bridge.core.velocity import Velocity
from motor_bridge.core.wheel_base import WheelBase
from motor_bridge.core.wheel_odometry import WheelOdometry, velocity_of_ways
from motor_bridge.core.wheel_reach import NOISE, WheelReach, are_within, farthest
from shirube_geometry import PlanarPose

_SPEED_TIME_MIN = 0.02  # least time of a speed measurement [s]
_BOOT_MIN = 0.3  # least time in which a controller resets and replies again [s]


@dataclass(frozen=True)
class OdometryState:
    """Odometry at one time.

    Attributes:
        T_odom_base: pose of the base in the odometry frame.
        covariance: covariance of (x, y, yaw) [m, m, rad], shape (3, 3).
        velocity: velocity of the base, in the base frame.
        velocity_covariance: covariance of linear speed and turn rate, shape (2, 2).
        angles: angles of the left and the right wheel since the start [rad].
        speeds: speeds of the left and the right wheel [rad/s].
    """

    T_odom_base: PlanarPose
    covariance: NDArray[np.float64]
    velocity: Velocity
    velocity_covariance: NDArray[np.float64]
    angles: tuple[float, float]
    speeds: tuple[float, float]


class EncoderOdometry:
    """Odometry from both encoders.

    Attributes:
        status_counts: number of reads by status.
        motion_bounds: possible wheel motion; set the commanded speeds there.
    """

    def __init__(self, base: WheelBase, settings: DriveSettings) -> None:
        """Start without counts."""
        self._base, self._radius = base, settings.wheel_radius
        self._odometry = WheelOdometry(base.separation, settings.odometry_noise)
        self.reach = WheelReach(base, settings)
        self._watch = CountWatch(self.reach)
        self.verdicts: Counter[CountVerdict] = Counter()
        self._angles = (0.0, 0.0)
        self._speeds = (0.0, 0.0)
        self._velocity_covariance = np.zeros((2, 2))
        self._rest(0.0)

    @property
    def state(self) -> OdometryState:
        """Current odometry."""
        per_metre = 1.0 / self._radius
        left, right = self._speeds
        return OdometryState(
            self._odometry.T_odom_base,
            self._odometry.covariance,
            velocity_of_ways(left, right, 1.0, self._base.separation),
            self._velocity_covariance,
            self._angles,
            (per_metre * left, per_metre * right),
        )

    def reset(self) -> None:
        """Set the current pose to the origin."""
        self._odometry.reset()

    def take(self, counts: WheelCounts, now: float) -> CountVerdict:
        """Check counts and update the odometry if they are accepted.

        Args:
            counts: counts as read.
            now: time of the read [s].
        """
        before = self._watch.good
        verdict = self._watch.judge(counts, now)
        self.verdicts[verdict] += 1
        if verdict is CountVerdict.TAKEN and before is not None:
            self._move(turns_between(before[0], counts), now - before[1])
        elif verdict is CountVerdict.RESTARTED:
            self._begin_anew(counts, now)
        return verdict

    def resume(self, counts: WheelCounts, now: float) -> CountVerdict:
        """Continue after a gap without counts.

        Counts that the wheels can have reached update the pose. If the controller may have been reset, or if the counts
        are inconsistent, the pose stays and the covariance grows by the possible motion: the pose never jumps.

        Args:
            counts: first counts after the gap.
            now: time of the read [s].
        """
        if self._watch.good is None:
            return self.take(counts, now)
        before, at = self._watch.good
        turns, elapsed = turns_between(before, counts), max(0.0, now - at)
        may_continue = are_within(turns, self.reach.without_word(elapsed))
        may_be_reset = elapsed > _BOOT_MIN and are_within(
            (counts.left, counts.right), self.reach.after_reset()
        )
        is_the_same = max(map(abs, turns)) <= 2.0 * NOISE  # then both cases give the same pose
        if may_continue and (is_the_same or not may_be_reset):
            self._watch.start(counts, now)
            self._move(turns, elapsed)
            self.verdicts[CountVerdict.TAKEN] += 1
            return CountVerdict.TAKEN
        self._begin_anew(counts, now)
        self.verdicts[CountVerdict.RESTARTED] += 1
        return CountVerdict.RESTARTED

    def time_jumped(self) -> None:
        """Restart with the next counts after a jump of the clock, as the elapsed time is unknown."""
        good = self._watch.good
        if good is not None:
            self._watch = CountWatch(self.reach)
            left, right = farthest(self.reach.without_word(math.inf))
            self._odometry.may_have_moved(*(self._base.metres_per_tick * t for t in (left, right)))

    def _begin_anew(self, counts: WheelCounts, now: float) -> None:
        good = self._watch.good
        elapsed = now - good[1] if good is not None else 0.0
        ways = (self._base.metres_per_tick * turn for turn in farthest(self.reach.without_word(elapsed)))
        self._odometry.may_have_moved(*ways)
        self._watch.start(counts, now)
        self._rest(elapsed)

    def _rest(self, elapsed: float) -> None:
        """Set the speeds to zero, as they are unknown."""
        self._speeds = (0.0, 0.0)
        time = max(elapsed, _SPEED_TIME_MIN)
        tick = self._base.metres_per_tick
        self._velocity_covariance = self._odometry.velocity_covariance(0.0, 0.0, time, tick)
        self.reach.start((0.0, 0.0))

    def _move(self, turns: tuple[int, int], elapsed: float) -> None:
        tick = self._base.metres_per_tick
        left, right = tick * turns[0], tick * turns[1]
        self._odometry.move(left, right)
        self._angles = (
            self._angles[0] + left / self._radius,
            self._angles[1] + right / self._radius,
        )
        if elapsed >= _SPEED_TIME_MIN:
            self._speeds = (left / elapsed, right / elapsed)
            self._velocity_covariance = self._odometry.velocity_covariance(left, right, elapsed, tick)
        self.reach.start((self._speeds[0] / tick, self._speeds[1] / tick))
