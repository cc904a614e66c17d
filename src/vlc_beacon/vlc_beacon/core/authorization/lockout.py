"""Rejects commands for a while after too many authentication failures."""

from __future__ import annotations

from collections import deque


class Lockout:
    """Limits brute-force attacks: with 5 guesses per minute, a 32-bit code takes 800 years on average.

    It applies to all beacons together; otherwise an attacker could guess with each ID.

    Args:
        failures_max: authentication failures within ``time`` that trigger the lockout.
        time: window of the failures, and duration of the lockout [s].
    """

    def __init__(self, failures_max: int, time: float) -> None:
        self._failures: deque[float] = deque(maxlen=failures_max)
        self._time = time
        self._locked_at: float | None = None

    def is_locked(self, stamp: float) -> bool:
        """Return whether commands are rejected at a time [s]. A clock that is set back ends the lockout."""
        return self._locked_at is not None and 0.0 <= stamp - self._locked_at < self._time

    def add_failure(self, stamp: float) -> None:
        """Add an authentication failure [s]."""
        self._failures.append(stamp)
        if len(self._failures) == self._failures.maxlen and 0.0 <= stamp - self._failures[0] < self._time:
            self._locked_at = stamp
            self._failures.clear()
