"""Buffer of the odometry of the last seconds, sorted by stamp."""

from __future__ import annotations

import math
from bisect import bisect_left

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.cumulative_odometry import CumulativeOdometry
from shirube_core.geometry import SE2

_EXTRAPOLATION_MAX = 250_000_000  # longest extrapolation beyond the last message, at constant velocity [ns]
_KEPT_BEFORE = 2  # messages kept before the horizon, for extrapolation
_DROP_BATCH = 256
_JUMP_XY, _JUMP_YAW = 0.02, 0.02  # a smaller step is never a jump [m, rad]


class OdometryBuffer:
    """Cumulative odometry at each message; messages may arrive in any order."""

    def __init__(self, settings: ArbiterSettings) -> None:
        """Start without odometry.

        Args:
            settings: odometry noise, and the speeds that count as a jump.
        """
        self._settings = settings
        self._stamps: list[int] = []
        self._poses: list[SE2] = []  # T_odom_base
        self._cumulative: list[CumulativeOdometry] = []
        self._is_jump: list[bool] = []

    @property
    def latest(self) -> int | None:
        """Newest stamp [ns], None without odometry."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, T_odom_base: SE2) -> int | None:
        """Insert a message; return the stamp [ns] from which lookups have changed, None for a duplicate stamp."""
        index = len(self._stamps)
        if index and stamp <= self._stamps[-1]:
            index = bisect_left(self._stamps, stamp)
            if self._stamps[index] == stamp:
                return None
        self._stamps.insert(index, stamp)
        self._poses.insert(index, T_odom_base)
        del self._cumulative[index:], self._is_jump[index:]
        for k in range(index, len(self._stamps)):
            self._accumulate(k)
        return self._stamps[index - 1] + 1 if index else -(2**63)

    def drop_before(self, horizon: int) -> None:
        """Drop messages older than a stamp [ns], in batches."""
        stale = bisect_left(self._stamps, horizon) - _KEPT_BEFORE
        if stale >= _DROP_BATCH:
            for rows in (self._stamps, self._poses, self._cumulative, self._is_jump):
                del rows[:stale]

    def lookup(self, stamp: int) -> CumulativeOdometry:
        """Return the cumulative odometry at a stamp [ns], interpolated or shortly extrapolated."""
        stamps = self._stamps
        if not stamps:
            return CumulativeOdometry(stamp, *(0.0,) * 12, stamp)
        k = bisect_left(stamps, stamp)
        if k == len(stamps):
            return self._extrapolate(stamp)
        if k == 0:
            first = self._cumulative[0]
            return first._replace(stamp=stamp, odometry_gap=first.odometry_gap - (first.stamp - stamp))
        return _interpolate(self._cumulative[k - 1], self._cumulative[k], stamp)

    def pose_at(self, stamp: int) -> SE2 | None:
        """Return ``T_odom_base`` at a stamp [ns], None without odometry at or before it."""
        if not self._stamps or stamp < self._stamps[0]:
            return None
        k = min(bisect_left(self._stamps, stamp), len(self._stamps) - 1)
        if stamp < self._stamps[k] and self._is_jump[k]:
            k -= 1
        last_message, cumulative = self._cumulative[k], self.lookup(stamp)
        step = SE2(last_message.x, last_message.y, last_message.yaw).inverse() @ SE2(
            cumulative.x, cumulative.y, cumulative.yaw
        )
        return self._poses[k] @ step

    def _accumulate(self, k: int) -> None:
        stamp, settings = self._stamps[k], self._settings
        if k == 0:
            self._cumulative.append(CumulativeOdometry(stamp, *(0.0,) * 12, stamp))
            self._is_jump.append(False)
            return
        before, previous, new = self._cumulative[k - 1], self._poses[k - 1], self._poses[k]
        seconds = (stamp - before.stamp) * 1e-9
        dx, dy = new.x - previous.x, new.y - previous.y
        distance, rotation = math.hypot(dx, dy), math.remainder(new.yaw - previous.yaw, math.tau)
        if (
            distance > settings.speed_max * seconds + _JUMP_XY
            or abs(rotation) > settings.turn_rate_max * seconds + _JUMP_YAW
        ):
            self._cumulative.append(
                before._replace(stamp=stamp, odometry_gap=before.odometry_gap + stamp - before.stamp)
            )
            self._is_jump.append(True)
            return
        yaw_offset = before.yaw - previous.yaw  # rotation from the odometry frame to the buffer frame
        cos, sin = math.cos(yaw_offset), math.sin(yaw_offset)
        cumulative = _add_step(
            before, (cos * dx - sin * dy, sin * dx + cos * dy, rotation), distance, stamp, settings
        )
        # After a gap in the odometry, the robot may have moved without being measured.
        gap = max(0, stamp - before.stamp - _EXTRAPOLATION_MAX)
        self._cumulative.append(cumulative._replace(odometry_gap=before.odometry_gap + gap))
        self._is_jump.append(False)

    def _extrapolate(self, stamp: int) -> CumulativeOdometry:
        last = self._cumulative[-1]
        ahead = stamp - last.stamp
        extrapolated = min(ahead, _EXTRAPOLATION_MAX)
        cumulative = last
        if len(self._cumulative) > 1 and not self._is_jump[-1]:
            before = self._cumulative[-2]
            if last.stamp - before.stamp <= _EXTRAPOLATION_MAX:
                cumulative = _interpolate(before, last, last.stamp + extrapolated)
        return cumulative._replace(stamp=stamp, odometry_gap=cumulative.odometry_gap + ahead - extrapolated)


def _add_step(
    before: CumulativeOdometry,
    step: tuple[float, float, float],
    distance: float,
    stamp: int,
    settings: ArbiterSettings,
) -> CumulativeOdometry:
    x, y = before.x + step[0], before.y + step[1]
    q = settings.odometry_noise_yaw**2 * (distance + abs(step[2]))
    return CumulativeOdometry(
        stamp,
        x,
        y,
        before.yaw + step[2],
        before.distance + distance,
        before.rotation + abs(step[2]),
        before.var_xy + settings.odometry_noise_xy**2 * distance,
        before.q + q,
        before.qx + q * x,
        before.qy + q * y,
        before.qxx + q * x * x,
        before.qxy + q * x * y,
        before.qyy + q * y * y,
        before.odometry_gap,
    )


def _interpolate(a: CumulativeOdometry, b: CumulativeOdometry, stamp: int) -> CumulativeOdometry:
    """Interpolate along the arc from a to b, or extrapolate it, to a stamp."""
    fraction = (stamp - a.stamp) / (b.stamp - a.stamp)
    rotation, dx, dy = b.yaw - a.yaw, b.x - a.x, b.y - a.y
    chord_angle = 0.5 * (fraction - 1.0) * rotation  # between the chords of the partial and the full arc
    cos, sin = fraction * math.cos(chord_angle), fraction * math.sin(chord_angle)
    moved = (cos * dx - sin * dy, sin * dx + cos * dy)
    remaining = 1.0 - fraction
    return CumulativeOdometry(
        stamp,
        a.x + moved[0],
        a.y + moved[1],
        a.yaw + fraction * rotation,
        remaining * a.distance + fraction * b.distance,
        remaining * a.rotation + fraction * b.rotation,
        remaining * a.var_xy + fraction * b.var_xy,
        remaining * a.q + fraction * b.q,
        remaining * a.qx + fraction * b.qx,
        remaining * a.qy + fraction * b.qy,
        remaining * a.qxx + fraction * b.qxx,
        remaining * a.qxy + fraction * b.qxy,
        remaining * a.qyy + fraction * b.qyy,
        a.odometry_gap + round(fraction * (b.odometry_gap - a.odometry_gap)),
    )
