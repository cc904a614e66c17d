"""Plausibility check of encoder counts, since the serial line has no checksums."""

from __future__ import annotations

from enum import Enum

from motor_bridge.core.serial_protocol import WheelCounts
from motor_bridge.core.wheel_reach import NOISE, WheelReach, are_within

RESTART_AFTER = 5
"""Consistent rejected counts in a row after which the encoders are taken as reset."""
_SPREAD = 1.5  # two consistent counts differ by at most this multiple of the greatest turn between them


class CountVerdict(Enum):
    """Outcome of the check of encoder counts."""

    TAKEN = 'accepted'
    ASK_AGAIN = 'implausible, read again'
    REFUSED = 'rejected, the wheels cannot have turned so far'
    RESTARTED = 'restarted after a jump of the encoders'


class CountWatch:
    """Checks counts against the possible motion of the wheels since the last accepted ones."""

    def __init__(self, reach: WheelReach) -> None:
        """Start without counts."""
        self._reach = reach
        self._good: tuple[WheelCounts, float] | None = None
        self._doubtful: tuple[WheelCounts, float] | None = None
        self._refused: tuple[WheelCounts, float] | None = None
        self._row = 0

    @property
    def good(self) -> tuple[WheelCounts, float] | None:
        """Last accepted counts and their time [s], None before the first."""
        return self._good

    def start(self, counts: WheelCounts, now: float) -> None:
        """Accept counts."""
        self._good, self._doubtful, self._refused, self._row = (counts, now), None, None, 0

    def judge(self, counts: WheelCounts, now: float) -> CountVerdict:
        """Check counts against the last accepted ones.

        A wheel that is pushed or stuck does not follow its commands: such counts are read again at once, and accepted
        if both reads are consistent.

        Args:
            counts: counts as read.
            now: time of the read [s].
        """
        if self._good is None:
            self.start(counts, now)
            return CountVerdict.TAKEN
        turns, elapsed = turns_between(self._good[0], counts), max(0.0, now - self._good[1])
        is_possible = max(map(abs, turns)) <= self._reach.pushed(elapsed)
        if are_within(turns, self._reach.usual(elapsed)) or (
            is_possible and self._continues(self._doubtful, counts, now)
        ):
            self.start(counts, now)
            return CountVerdict.TAKEN
        if self._doubtful is None:
            self._doubtful = counts, now
            return CountVerdict.ASK_AGAIN
        confirmed = self._continues(self._doubtful, counts, now)
        self._doubtful = None
        return self._refuse(counts, now) if confirmed else CountVerdict.REFUSED

    def _refuse(self, counts: WheelCounts, now: float) -> CountVerdict:
        self._row = self._row + 1 if self._continues(self._refused, counts, now) else 1
        self._refused = counts, now
        return CountVerdict.RESTARTED if self._row >= RESTART_AFTER else CountVerdict.REFUSED

    def _continues(self, before: tuple[WheelCounts, float] | None, counts: WheelCounts, now: float) -> bool:
        """Return whether counts are consistent with earlier ones."""
        if before is None:
            return False
        elapsed = max(0.0, now - before[1])
        most = _SPREAD * (self._reach.pushed(elapsed) - NOISE) + NOISE
        return max(map(abs, turns_between(before[0], counts))) <= most


def turns_between(before: WheelCounts, after: WheelCounts) -> tuple[int, int]:
    """Return the differences of the counts [ticks], modulo 2^32 with the least absolute value."""
    half = 1 << 31
    left, right = (
        (new - old + half) % (2 * half) - half
        for old, new in ((before.left, after.left), (before.right, after.right))
    )
    return left, right
