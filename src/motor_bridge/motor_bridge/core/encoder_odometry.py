"""Odometry and joint states from checked encoder counts."""

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motor_bridge.core.controller_protocol import WheelCounts
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity
from motor_bridge.core.encoder_monitor import (
    COUNT_NOISE,
    CountStatus,
    EncoderMonitor,
    WheelMotionBounds,
    count_difference,
    is_within_bounds,
    max_abs_turns,
)
from shirube_core.geometry import SE2

_SIGMA_START = 1e-4  # [m] and [rad]; many programs reject a zero covariance


class WheelOdometry:
    """Integrates the distances of both wheels.

    Attributes:
        T_odom_base: pose of the base in the odometry frame.
        covariance: covariance of (x, y, yaw) [m, m, rad], shape (3, 3).
    """

    def __init__(self, separation: float, noise: float) -> None:
        """Start at the origin; ``noise`` is the standard deviation of a wheel distance after one metre [m]."""
        self._separation, self._noise = separation, noise
        self.reset()

    def reset(self) -> None:
        """Reset the pose to the origin."""
        self.T_odom_base = SE2(0.0, 0.0, 0.0)
        self.covariance: NDArray[np.float64] = _SIGMA_START**2 * np.eye(3)

    def move(self, left: float, right: float) -> None:
        """Add wheel distances [m]: an arc of length (l + r)/2 that turns by (r - l)/b."""
        self._propagate_covariance(left, right, (self._noise**2 * abs(left), self._noise**2 * abs(right)))
        turn = (right - left) / self._separation
        self.T_odom_base = self.T_odom_base @ SE2.exp(0.5 * (left + right), 0.0, turn)

    def add_uncounted_motion(self, left: float, right: float) -> None:
        """Inflate the covariance by the greatest uncounted distances of the wheels, one standard deviation each [m]."""
        self._propagate_covariance(0.0, 0.0, (left**2, right**2))
        # Turns during the motion move the robot sideways, which the first order neglects.
        distance = 0.5 * (abs(left) + abs(right))
        self.covariance[:2, :2] += distance**2 * np.eye(2)

    def velocity_covariance(self, left: float, right: float, elapsed: float, tick: float) -> NDArray[np.float64]:
        """Return the covariance of linear speed and turn rate, shape (2, 2), from wheel distances [m] in some time [s].

        Each distance has two rounded counts; ``tick`` is the distance per tick [m].
        """
        variances = [(self._noise**2 * abs(distance) + tick**2 / 6.0) / elapsed**2 for distance in (left, right)]
        G = np.array([[0.5, 0.5], [-1.0 / self._separation, 1.0 / self._separation]])
        return G @ np.diag(variances) @ G.T

    def _propagate_covariance(self, left: float, right: float, variances: tuple[float, float]) -> None:
        """Propagate the covariance over a step: F Σ Fᵀ + G diag(σ_l², σ_r²) Gᵀ."""
        forward, turn = 0.5 * (left + right), (right - left) / self._separation
        middle = self.T_odom_base.yaw + 0.5 * turn
        cos, sin = math.cos(middle), math.sin(middle)
        F = np.array([[1.0, 0.0, -forward * sin], [0.0, 1.0, forward * cos], [0.0, 0.0, 1.0]])
        half, inverse = 0.5 * forward / self._separation, 1.0 / self._separation
        G = np.array(
            [
                [0.5 * cos + half * sin, 0.5 * cos - half * sin],
                [0.5 * sin - half * cos, 0.5 * sin + half * cos],
                [-inverse, inverse],
            ]
        )
        covariance = F @ self.covariance @ F.T + G @ np.diag(variances) @ G.T
        self.covariance = 0.5 * (covariance + covariance.T)


def velocity_from_distances(left: float, right: float, elapsed: float, separation: float) -> Velocity:
    """Return the mean velocity of wheel distances [m] in some time [s]."""
    return Velocity(0.5 * (left + right) / elapsed, (right - left) / (separation * elapsed))


_SPEED_TIME_MIN = 0.02  # least time of a speed measurement [s]
_BOOT_TIME_MIN = 0.3  # least time in which a controller resets and replies again [s]


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

    T_odom_base: SE2
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

    def __init__(self, kinematics: DiffDriveKinematics, settings: DriveSettings) -> None:
        self._kinematics, self._radius = kinematics, settings.wheel_radius
        self._odometry = WheelOdometry(kinematics.separation, settings.odometry_noise)
        self.motion_bounds = WheelMotionBounds(kinematics, settings)
        self._monitor = EncoderMonitor(self.motion_bounds)
        self.status_counts: Counter[CountStatus] = Counter()
        self._angles = (0.0, 0.0)
        self._speeds = (0.0, 0.0)
        self._velocity_covariance = np.zeros((2, 2))
        self._set_stationary(0.0)

    @property
    def state(self) -> OdometryState:
        """Current odometry."""
        per_metre = 1.0 / self._radius
        left, right = self._speeds
        return OdometryState(
            self._odometry.T_odom_base,
            self._odometry.covariance,
            velocity_from_distances(left, right, 1.0, self._kinematics.separation),
            self._velocity_covariance,
            self._angles,
            (per_metre * left, per_metre * right),
        )

    def reset(self) -> None:
        """Set the current pose to the origin."""
        self._odometry.reset()

    def update(self, counts: WheelCounts, now: float) -> CountStatus:
        """Check counts that were read at a time [s], and update the odometry if they are accepted."""
        before = self._monitor.last_accepted
        status = self._monitor.check(counts, now)
        self.status_counts[status] += 1
        if status is CountStatus.ACCEPTED and before is not None:
            self._move(count_difference(before[0], counts), now - before[1])
        elif status is CountStatus.RESTARTED:
            self._restart(counts, now)
        return status

    def resume(self, counts: WheelCounts, now: float) -> CountStatus:
        """Continue after a gap with the first counts, read at a time [s].

        Counts that the wheels can have reached update the pose. If the controller may have been reset, or if the counts
        are inconsistent, the pose stays and the covariance grows by the possible motion: the pose never jumps.
        """
        if self._monitor.last_accepted is None:
            return self.update(counts, now)
        before, at = self._monitor.last_accepted
        differences, elapsed = count_difference(before, counts), max(0.0, now - at)
        may_continue = is_within_bounds(differences, self.motion_bounds.link_lost_bounds(elapsed))
        may_be_reset = elapsed > _BOOT_TIME_MIN and is_within_bounds(
            (counts.left, counts.right), self.motion_bounds.reset_bounds()
        )
        is_unmoved = max(map(abs, differences)) <= 2.0 * COUNT_NOISE  # then both cases give the same pose
        if may_continue and (is_unmoved or not may_be_reset):
            self._monitor.start(counts, now)
            self._move(differences, elapsed)
            self.status_counts[CountStatus.ACCEPTED] += 1
            return CountStatus.ACCEPTED
        self._restart(counts, now)
        self.status_counts[CountStatus.RESTARTED] += 1
        return CountStatus.RESTARTED

    def handle_time_jump(self) -> None:
        """Restart with the next counts after a jump of the clock, as the elapsed time is unknown."""
        if self._monitor.last_accepted is not None:
            self._monitor = EncoderMonitor(self.motion_bounds)
            self._add_possible_motion(math.inf)

    def _restart(self, counts: WheelCounts, now: float) -> None:
        good = self._monitor.last_accepted
        elapsed = now - good[1] if good is not None else 0.0
        self._add_possible_motion(elapsed)
        self._monitor.start(counts, now)
        self._set_stationary(elapsed)

    def _add_possible_motion(self, elapsed: float) -> None:
        """Inflate the covariance by what the wheels may have turned without counts in some time [s]."""
        turns = max_abs_turns(self.motion_bounds.link_lost_bounds(elapsed))
        self._odometry.add_uncounted_motion(*(self._kinematics.metres_per_tick * turn for turn in turns))

    def _set_stationary(self, elapsed: float) -> None:
        """Set the speeds to zero, as they are unknown."""
        self._speeds = (0.0, 0.0)
        time = max(elapsed, _SPEED_TIME_MIN)
        tick = self._kinematics.metres_per_tick
        self._velocity_covariance = self._odometry.velocity_covariance(0.0, 0.0, time, tick)
        self.motion_bounds.start((0.0, 0.0))

    def _move(self, differences: tuple[int, int], elapsed: float) -> None:
        tick = self._kinematics.metres_per_tick
        left, right = tick * differences[0], tick * differences[1]
        self._odometry.move(left, right)
        self._angles = (self._angles[0] + left / self._radius, self._angles[1] + right / self._radius)
        if elapsed >= _SPEED_TIME_MIN:
            self._speeds = (left / elapsed, right / elapsed)
            self._velocity_covariance = self._odometry.velocity_covariance(left, right, elapsed, tick)
        self.motion_bounds.start((self._speeds[0] / tick, self._speeds[1] / tick))
