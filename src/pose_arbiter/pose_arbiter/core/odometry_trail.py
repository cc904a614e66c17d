"""Buffer of the odometry of the last seconds, sorted by stamp."""

from __future__ import annotations

import math
from bisect import bisect_left

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.odometry_mark import OdometryMark
from shirube_geometry import PlanarPose

_HOLD = 250_000_000  # longest extrapolation beyond the last message, at constant velocity [ns]
_KEPT_BEFORE = 2  # messages kept before the horizon, for extrapolation
_DROPPED_AT_ONCE = 256
_JUMP_XY, _JUMP_YAW = 0.02, 0.02  # a smaller step is never a jump [m, rad]


class OdometryTrail:
    """Cumulative odometry at each message; messages may arrive in any order."""

    def __init__(self, settings: ArbiterSettings) -> None:
        """Start without odometry.

        Args:
            settings: odometry noise, and the speeds that count as a jump.
        """
        self._settings = settings
        self._stamps: list[int] = []
        self._raw: list[PlanarPose] = []  # T_odom_base
        self._marks: list[OdometryMark] = []
        self._is_jump: list[bool] = []

    @property
    def latest(self) -> int | None:
        """Newest stamp [ns], None without odometry."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, T_odom_base: PlanarPose) -> int | None:
        """Insert a message; return the stamp [ns] from which lookups have changed, None for a duplicate stamp."""
        place = len(self._stamps)
        if place and stamp <= self._stamps[-1]:
            place = bisect_left(self._stamps, stamp)
            if self._stamps[place] == stamp:
                return None
        self._stamps.insert(place, stamp)
        self._raw.insert(place, T_odom_base)
        del self._marks[place:], self._is_jump[place:]
        for k in range(place, len(self._stamps)):
            self._append_mark(k)
        return self._stamps[place - 1] + 1 if place else -(2**63)

    def drop_before(self, horizon: int) -> None:
        """Drop messages older than a stamp [ns], in batches."""
        stale = bisect_left(self._stamps, horizon) - _KEPT_BEFORE
        if stale >= _DROPPED_AT_ONCE:
            for rows in (self._stamps, self._raw, self._marks, self._is_jump):
                del rows[:stale]

    def mark_at(self, stamp: int) -> OdometryMark:
        """Return the cumulative odometry at a stamp [ns], interpolated or shortly extrapolated."""
        stamps = self._stamps
        if not stamps:
            return OdometryMark(stamp, *(0.0,) * 12, stamp)
        k = bisect_left(stamps, stamp)
        if k == len(stamps):
            return self._beyond(stamp)
        if k == 0:
            first = self._marks[0]
            return first._replace(stamp=stamp, blind=first.blind - (first.stamp - stamp))
        return _share(self._marks[k - 1], self._marks[k], stamp)

    def odometry_at(self, stamp: int) -> PlanarPose | None:
        """Return ``T_odom_base`` at a stamp [ns], None without odometry at or before it."""
        if not self._stamps or stamp < self._stamps[0]:
            return None
        k = min(bisect_left(self._stamps, stamp), len(self._stamps) - 1)
        if stamp < self._stamps[k] and self._is_jump[k]:
            k -= 1
        base, mark = self._marks[k], self.mark_at(stamp)
        step = PlanarPose(base.x, base.y, base.yaw).inverse() @ PlanarPose(mark.x, mark.y, mark.yaw)
        return self._raw[k] @ step

    def _append_mark(self, k: int) -> None:
        stamp, settings = self._stamps[k], self._settings
        if k == 0:
            self._marks.append(OdometryMark(stamp, *(0.0,) * 12, stamp))
            self._is_jump.append(False)
            return
        before, old, new = self._marks[k - 1], self._raw[k - 1], self._raw[k]
        seconds = (stamp - before.stamp) * 1e-9
        dx, dy = new.x - old.x, new.y - old.y
        way, turn = math.hypot(dx, dy), math.remainder(new.yaw - old.yaw, math.tau)
        if (
            way > settings.speed_max * seconds + _JUMP_XY
            or abs(turn) > settings.turn_rate_max * seconds + _JUMP_YAW
        ):
            self._marks.append(before._replace(stamp=stamp, blind=before.blind + stamp - before.stamp))
            self._is_jump.append(True)
            return
        between = before.yaw - old.yaw  # rotation from the odometry frame to the buffer frame
        cos, sin = math.cos(between), math.sin(between)
        mark = _stepped(before, (cos * dx - sin * dy, sin * dx + cos * dy, turn), way, stamp, settings)
        # After a gap in the odometry, the robot may have moved without being measured.
        missed = max(0, stamp - before.stamp - _HOLD)
        self._marks.append(mark._replace(blind=before.blind + missed))
        self._is_jump.append(False)

    def _beyond(self, stamp: int) -> OdometryMark:
        last = self._marks[-1]
        ahead = stamp - last.stamp
        seen = min(ahead, _HOLD)
        mark = last
        if len(self._marks) > 1 and not self._is_jump[-1]:
            before = self._marks[-2]
            if last.stamp - before.stamp <= _HOLD:
                mark = _share(before, last, last.stamp + seen)
        return mark._replace(stamp=stamp, blind=mark.blind + ahead - seen)


def _stepped(
    before: OdometryMark, step: tuple[float, float, float], way: float, stamp: int, settings: ArbiterSettings
) -> OdometryMark:
    x, y = before.x + step[0], before.y + step[1]
    q = settings.turn_noise**2 * (way + abs(step[2]))
    return OdometryMark(
        stamp,
        x,
        y,
        before.yaw + step[2],
        before.way + way,
        before.turn + abs(step[2]),
        before.spread + settings.way_noise**2 * way,
        before.q + q,
        before.qx + q * x,
        before.qy + q * y,
        before.qxx + q * x * x,
        before.qxy + q * x * y,
        before.qyy + q * y * y,
        before.blind,
    )


def _share(a: OdometryMark, b: OdometryMark, stamp: int) -> OdometryMark:
    """Interpolate along the arc from a to b, or extrapolate it, to a stamp."""
    share = (stamp - a.stamp) / (b.stamp - a.stamp)
    turn, dx, dy = b.yaw - a.yaw, b.x - a.x, b.y - a.y
    bend = 0.5 * (share - 1.0) * turn  # between the chords of the partial and the full arc
    cos, sin = share * math.cos(bend), share * math.sin(bend)
    moved = (cos * dx - sin * dy, sin * dx + cos * dy)
    rest = 1.0 - share
    return OdometryMark(
        stamp,
        a.x + moved[0],
        a.y + moved[1],
        a.yaw + share * turn,
        rest * a.way + share * b.way,
        rest * a.turn + share * b.turn,
        rest * a.spread + share * b.spread,
        rest * a.q + share * b.q,
        rest * a.qx + share * b.qx,
        rest * a.qy + share * b.qy,
        rest * a.qxx + share * b.qxx,
        rest * a.qxy + share * b.qxy,
        rest * a.qyy + share * b.qyy,
        a.blind + round(share * (b.blind - a.blind)),
    )
