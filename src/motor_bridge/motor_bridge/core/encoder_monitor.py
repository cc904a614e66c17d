"""Plausibility check of encoder counts, since the serial line has no checksums."""

from __future__ import annotations

from enum import Enum

from motor_bridge.core.serial_protocol import WheelCounts
from motor_bridge.core.wheel_motion_bounds import COUNT_NOISE, WheelMotionBounds, is_within_bounds

RESTART_COUNT = 5
"""Consistent rejected counts in a row after which the encoders are taken as reset."""
_CONTINUATION_FACTOR = (
    1.5  # two consistent counts differ by at most this multiple of the greatest turn between them
)


class CountStatus(Enum):
    """Outcome of the check of encoder counts."""

    ACCEPTED = 'accepted'
    RETRY = 'implausible, read again'
    REJECTED = 'rejected, the wheels cannot have turned so far'
    RESTARTED = 'restarted after a jump of the encoders'


class EncoderMonitor:
    """Checks counts against the possible motion of the wheels since the last accepted ones."""

    def __init__(self, bounds: WheelMotionBounds) -> None:
        """Start without counts."""
        self._bounds = bounds
        self._last_accepted: tuple[WheelCounts, float] | None = None
        self._unconfirmed: tuple[WheelCounts, float] | None = None
        self._rejected: tuple[WheelCounts, float] | None = None
        self._rejected_in_row = 0

    @property
    def last_accepted(self) -> tuple[WheelCounts, float] | None:
        """Last accepted counts and their time [s], None before the first."""
        return self._last_accepted

    def start(self, counts: WheelCounts, now: float) -> None:
        """Accept counts."""
        self._last_accepted, self._unconfirmed, self._rejected, self._rejected_in_row = (
            (counts, now),
            None,
            None,
            0,
        )

    def check(self, counts: WheelCounts, now: float) -> CountStatus:
        """Check counts against the last accepted ones.

        A wheel that is pushed or stuck does not follow its commands: such counts are read again at once, and accepted
        if both reads are consistent.

        Args:
            counts: counts as read.
            now: time of the read [s].
        """
        if self._last_accepted is None:
            self.start(counts, now)
            return CountStatus.ACCEPTED
        difference, elapsed = (
            count_difference(self._last_accepted[0], counts),
            max(0.0, now - self._last_accepted[1]),
        )
        is_reachable = max(map(abs, difference)) <= self._bounds.pushed_turn_max(elapsed)
        if is_within_bounds(difference, self._bounds.commanded_bounds(elapsed)) or (
            is_reachable and self._is_continuation(self._unconfirmed, counts, now)
        ):
            self.start(counts, now)
            return CountStatus.ACCEPTED
        if self._unconfirmed is None:
            self._unconfirmed = counts, now
            return CountStatus.RETRY
        confirmed = self._is_continuation(self._unconfirmed, counts, now)
        self._unconfirmed = None
        return self._reject(counts, now) if confirmed else CountStatus.REJECTED

    def _reject(self, counts: WheelCounts, now: float) -> CountStatus:
        self._rejected_in_row = (
            self._rejected_in_row + 1 if self._is_continuation(self._rejected, counts, now) else 1
        )
        self._rejected = counts, now
        return CountStatus.RESTARTED if self._rejected_in_row >= RESTART_COUNT else CountStatus.REJECTED

    def _is_continuation(
        self, before: tuple[WheelCounts, float] | None, counts: WheelCounts, now: float
    ) -> bool:
        """Return whether counts are consistent with earlier ones."""
        if before is None:
            return False
        elapsed = max(0.0, now - before[1])
        limit = _CONTINUATION_FACTOR * (self._bounds.pushed_turn_max(elapsed) - COUNT_NOISE) + COUNT_NOISE
        return max(map(abs, count_difference(before[0], counts))) <= limit


def count_difference(before: WheelCounts, after: WheelCounts) -> tuple[int, int]:
    """Return the differences of the counts [ticks], modulo 2^32 with the least absolute value."""
    half = 1 << 31
    left, right = (
        (new - old + half) % (2 * half) - half
        for old, new in ((before.left, after.left), (before.right, after.right))
    )
    return left, right
