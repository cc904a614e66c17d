"""Refuses commands for a while after too many wrong codes of authentication."""

from __future__ import annotations

from collections import deque


class Lockout:
    """Makes guessing hopeless: with 5 guesses in a minute, a code of 32 bits takes 800 years on average.

    It holds for all beacons together; otherwise a guesser would get a try for each ID.

    Args:
        bad_max: wrong codes within the time until the lock closes.
        time: how long they are remembered, and how long the lock stays closed [s].
    """

    def __init__(self, bad_max: int, time: float) -> None:
        self._bad: deque[float] = deque(maxlen=bad_max)
        self._time = time
        self._closed_at: float | None = None

    def is_closed(self, stamp: float) -> bool:
        """Return whether commands are refused now [s]. A clock that was set back opens the lock."""
        return self._closed_at is not None and 0.0 <= stamp - self._closed_at < self._time

    def add_bad(self, stamp: float) -> None:
        """Take note of a wrong code [s]."""
        self._bad.append(stamp)
        if len(self._bad) == self._bad.maxlen and 0.0 <= stamp - self._bad[0] < self._time:
            self._closed_at = stamp
            self._bad.clear()
