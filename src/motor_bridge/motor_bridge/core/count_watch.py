"""Tells counts that can be believed from counts that a line without checksums made up."""

from __future__ import annotations

from enum import Enum

from motor_bridge.core.serial_protocol import WheelCounts
from motor_bridge.core.wheel_reach import NOISE, WheelReach, are_within

RESTART_AFTER = 5
"""So many refused counts in a row that continue one another are those of encoders that began anew."""
_SPREAD = 1.5  # two counts of one moment differ by no more times what the wheel turns between them


class CountVerdict(Enum):
    """What becomes of counts."""

    TAKEN = 'taken'
    ASK_AGAIN = 'doubtful, asked a second time'
    REFUSED = 'refused, the wheels cannot have turned so far'
    RESTARTED = 'began anew, the encoders jumped'


class CountWatch:
    """Compares counts with what the wheels can have done since the last good ones."""

    def __init__(self, reach: WheelReach) -> None:
        """Wait for the first counts."""
        self._reach = reach
        self._good: tuple[WheelCounts, float] | None = None
        self._doubtful: tuple[WheelCounts, float] | None = None
        self._refused: tuple[WheelCounts, float] | None = None
        self._row = 0

    @property
    def good(self) -> tuple[WheelCounts, float] | None:
        """The last good counts and their time [s], None before the first."""
        return self._good

    def start(self, counts: WheelCounts, now: float) -> None:
        """Take counts as good."""
        self._good, self._doubtful, self._refused, self._row = (counts, now), None, None, 0

    def judge(self, counts: WheelCounts, now: float) -> CountVerdict:
        """Judge counts; good ones are those to which the next are compared.

        A wheel that somebody pushes, or that is stuck, does not do what it is told: such counts are asked for a second
        time at once, and taken if both say the same.

        Args:
            counts: as read.
            now: when [s].
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
        """Return whether counts are what comes a little after others."""
        if before is None:
            return False
        elapsed = max(0.0, now - before[1])
        most = _SPREAD * (self._reach.pushed(elapsed) - NOISE) + NOISE
        return max(map(abs, turns_between(before[0], counts))) <= most


def turns_between(before: WheelCounts, after: WheelCounts) -> tuple[int, int]:
    """Return how far the wheels turned [ticks], across the wrap of 32 bits; the shorter way round is taken."""
    half = 1 << 31
    left, right = (
        (new - old + half) % (2 * half) - half
        for old, new in ((before.left, after.left), (before.right, after.right))
    )
    return left, right
