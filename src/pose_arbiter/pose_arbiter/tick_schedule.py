"""Instants at which a pose is due, none of which load or a coarse clock swallows."""

from __future__ import annotations

_LONGEST_ARREARS = 500_000_000  # what is due longer is due no more [ns]


class TickSchedule:
    """Multiples of a period on the clock; whole numbers, so that nothing drifts."""

    def __init__(self, rate: float) -> None:
        """Begin with the first time that is asked for.

        Args:
            rate: ticks a second.
        """
        self._period = round(1e9 / rate)
        self._done: int | None = None

    def start_again(self) -> None:
        """Forget what is due, as time jumped."""
        self._done = None

    def due(self, now: int) -> range:
        """Return the instants since the last call up to now [ns]."""
        last = now // self._period
        if self._done is None:
            self._done = last - 1
        first = max(self._done + 1, (now - _LONGEST_ARREARS) // self._period + 1)
        self._done = max(self._done, last)
        return range(first * self._period, last * self._period + 1, self._period)
