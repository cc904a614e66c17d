"""Rejects commands for a while after too many authentication failures."""

from __future__ import annotations

from collections import deque


class Lockout:
    """Limits brute-force attacks: with 5 guesses per minute, a 32-bit code takes 800 years on average.

    It applies to all beacons together; otherwise an attacker could guess with each ID.

    Args:
        bad_max: authentication failures within ``time`` that trigger the lockout.
        time: window of the failures, and duration of the lockout [s].
    """

    def __init__(self, bad_max: int, time: float) -> None:
        self._bad: deque[float] = deque(maxlen=bad_max)
        self._time = time
        self._closed_at: float | None = None

    def is_closed(self, stamp: float) -> bool:
        """Return whether commands are rejected at a time [s]. A clock that is set back ends the lockout."""
        return self._closed_at is not None and 0.0 <= stamp - self._closed_at < self._time

    def add_bad(self, stamp: float) -> None:
        """Add an authentication failure [s]."""
        self._bad.append(stamp)
        if len(self._bad) == self._bad.maxlen and 0.0 <= stamp - self._bad[0] < self._time:
            self._closed_at = stamp
            self._bad.clear()
