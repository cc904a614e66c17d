"""Buffer of poses by stamp, sorted: the pose at a stamp and the motion between two stamps."""

import math
from bisect import bisect_left, bisect_right
from enum import Enum

from shirube_core.geometry import SE2
from shirube_core.motion.cumulative_odometry import CumulativeOdometry

_JUMP_XY, _JUMP_YAW = 0.02, 0.02  # a smaller step is never a jump [m, rad]
_STEP_MIN = 1_000_000  # a shorter step gives no velocity [ns]
_KEPT_BEFORE = 2  # messages kept before the history, for interpolation
_DROP_BATCH = 256

Twist = tuple[float, float, float]


class NoPoseReason(Enum):
    """Why there is no pose at a stamp, or no motion between two."""

    EMPTY = 'no odometry'
    TOO_OLD = 'older than the odometry'
    TOO_NEW = 'newer than the odometry'
    GAP = 'no odometry around the stamp'
    JUMPED = 'the odometry jumped'


class OdometryBuffer:
    """Poses of the base in any order of arrival, with constant twist between two messages and a little beyond.

    The answers depend only on the messages, not on their order of arrival.
    """

    def __init__(
        self,
        history: int = 60_000_000_000,
        gap_max: int = 500_000_000,
        extrapolation_max: int = 250_000_000,
        speed_max: float = 3.0,
        turn_rate_max: float = 10.0,
    ) -> None:
        """Start without poses.

        Args:
            history: older poses than this before the newest are dropped [ns].
            gap_max: longest time between two messages that is interpolated [ns].
            extrapolation_max: longest extrapolation before the first and beyond the last message [ns].
            speed_max: a faster step is a jump [m/s].
            turn_rate_max: a faster step is a jump [rad/s].
        """
        self._history, self._gap_max, self._extrapolation_max = history, gap_max, extrapolation_max
        self._speed_max, self._turn_rate_max = speed_max, turn_rate_max
        self._stamps: list[int] = []
        self._poses: list[SE2] = []
        self._twists: list[Twist | None] = []  # of the step to each message, None for the first one and a jump
        self._cumulative: list[CumulativeOdometry] = []
        self._jump_stamps: list[int] = []

    @property
    def latest(self) -> int | None:
        """Newest stamp [ns], None without poses."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, pose: SE2) -> int | None:
        """Insert a pose by its stamp [ns].

        Returns:
            the stamp [ns] from which lookups have changed; None if the stamp is too old or there already.
        """
        stamps, index = self._stamps, len(self._stamps)
        if index and stamp <= stamps[-1]:
            index = bisect_left(stamps, stamp)
            if stamps[index] == stamp or stamp < stamps[-1] - self._history:
                return None
        stamps.insert(index, stamp)
        self._poses.insert(index, pose)
        del self._twists[index:], self._cumulative[index:]
        del self._jump_stamps[bisect_left(self._jump_stamps, stamp) :]
        for k in range(index, len(stamps)):
            self._add_step(k)
        changed = stamps[index - 1] + 1 if index else -(2**63)
        stale = bisect_left(stamps, stamps[-1] - self._history) - _KEPT_BEFORE
        if stale >= _DROP_BATCH:
            del stamps[:stale], self._poses[:stale], self._twists[:stale], self._cumulative[:stale]
            del self._jump_stamps[: bisect_right(self._jump_stamps, stamps[0])]
        return changed

    def pose_at(self, stamp: int) -> SE2 | NoPoseReason:
        """Return the pose at a stamp [ns]: interpolated, or shortly extrapolated at constant twist."""
        reason = self._why_unknown(stamp)
        if reason is not None:
            return reason
        index, twist = self._arc_to(stamp)
        return self._poses[index] if twist is None else self._poses[index] @ SE2.exp(*twist)

    def motion(self, start: int, end: int) -> SE2 | NoPoseReason:
        """Return the pose at the stamp ``end`` [ns] in the base frame at ``start`` [ns], in either order."""
        first, last = self.pose_at(start), self.pose_at(end)
        if isinstance(first, NoPoseReason):
            return first
        if isinstance(last, NoPoseReason):
            return last
        jumps_before_start, jumps_before_end = (bisect_right(self._jump_stamps, s) for s in (start, end))
        return first.inverse() @ last if jumps_before_start == jumps_before_end else NoPoseReason.JUMPED

    def twist_at(self, stamp: int) -> Twist:
        """Return the velocity along x and y [m/s] and the yaw rate [rad/s] of the base, zeros if unknown."""
        if self._why_unknown(stamp) is not None:
            return 0.0, 0.0, 0.0
        k = self._step_after(max(bisect_right(self._stamps, stamp) - 1, 0))
        twist = None if k is None else self._twists[k]
        if k is None or twist is None:
            return 0.0, 0.0, 0.0
        rate = 1e9 / (self._stamps[k] - self._stamps[k - 1])
        return rate * twist[0], rate * twist[1], rate * twist[2]

    def lookup(self, stamp: int) -> CumulativeOdometry:
        """Return the cumulative odometry at a stamp [ns]; time without odometry counts as gap."""
        stamps = self._stamps
        if not stamps:
            return CumulativeOdometry(stamp, *(0.0,) * 10, stamp)
        if stamp < stamps[0]:
            first = self._cumulative[0]
            return first._replace(stamp=stamp, odometry_gap=first.odometry_gap - (first.stamp - stamp))
        index, twist = self._arc_to(stamp)
        start = self._cumulative[index]
        if start.stamp == stamp:
            return start
        gap = max(0, stamp - stamps[-1] - self._extrapolation_max)
        if index + 1 < len(stamps):  # a part of the gap until the next message
            step = self._cumulative[index + 1]
            fraction = (stamp - start.stamp) / (step.stamp - start.stamp)
            gap = round(fraction * (step.odometry_gap - start.odometry_gap))
        if twist is None:
            return start._replace(stamp=stamp, odometry_gap=start.odometry_gap + gap)
        return start.moved(twist, stamp, gap)

    def _why_unknown(self, stamp: int) -> NoPoseReason | None:
        stamps = self._stamps
        if not stamps:
            return NoPoseReason.EMPTY
        if stamp < stamps[0] - self._extrapolation_max:
            return NoPoseReason.TOO_OLD
        if stamp > stamps[-1] + self._extrapolation_max:
            return NoPoseReason.TOO_NEW
        k = bisect_left(stamps, stamp)
        inside = 0 < k < len(stamps) and stamp < stamps[k]
        return NoPoseReason.GAP if inside and stamps[k] - stamps[k - 1] > self._gap_max else None

    def _arc_to(self, stamp: int) -> tuple[int, Twist | None]:
        """Return the message to start from and the twist from it to a stamp, None for no motion."""
        stamps = self._stamps
        index = max(bisect_right(stamps, stamp) - 1, 0)
        ahead = stamp - stamps[index]
        k = self._step_after(index) if ahead else None
        twist = None if k is None else self._twists[k]
        if k is None or twist is None:
            return index, None
        if k <= index:
            ahead = min(ahead, self._extrapolation_max)
        fraction = ahead / (stamps[k] - stamps[k - 1])
        return index, (fraction * twist[0], fraction * twist[1], fraction * twist[2])

    def _step_after(self, index: int) -> int | None:
        """Return the step that begins at a message; after the last message the latest one that gives a velocity."""
        stamps, k = self._stamps, index + 1
        if k < len(stamps):
            return k
        k = index
        while k > 0 and self._twists[k] is not None and stamps[k] - stamps[k - 1] < _STEP_MIN:
            k -= 1
        return k if k > 0 and stamps[k] - stamps[k - 1] <= self._gap_max else None

    def _add_step(self, k: int) -> None:
        """Accumulate the step to message k."""
        stamp = self._stamps[k]
        if k == 0:
            self._twists.append(None)
            self._cumulative.append(CumulativeOdometry(stamp, *(0.0,) * 10, stamp))
            return
        before, step = self._cumulative[k - 1], self._poses[k - 1].inverse() @ self._poses[k]
        elapsed = stamp - before.stamp
        if (
            math.hypot(step.x, step.y) > self._speed_max * 1e-9 * elapsed + _JUMP_XY
            or abs(step.yaw) > self._turn_rate_max * 1e-9 * elapsed + _JUMP_YAW
        ):
            self._twists.append(None)
            self._jump_stamps.append(stamp)
            self._cumulative.append(before._replace(stamp=stamp, odometry_gap=before.odometry_gap + elapsed))
            return
        # After a silence, the robot may have moved without being measured.
        gap = elapsed - self._extrapolation_max if elapsed > self._gap_max else 0
        twist = step.log()
        self._twists.append(twist)
        self._cumulative.append(before.moved(twist, stamp, gap))
