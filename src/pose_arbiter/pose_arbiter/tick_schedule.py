"""Output stamps at a fixed rate, none of which is skipped under load or with a coarse clock."""

from __future__ import annotations

_BACKLOG_MAX = 500_000_000  # older ticks are dropped [ns]


class TickSchedule:
    """Ticks at multiples of the period; integers, so that they do not drift."""

    def __init__(self, rate: float) -> None:
        """Start at the first call of `due`.

        Args:
            rate: tick rate [1/s].
        """
        self._period = round(1e9 / rate)
        self._last_done: int | None = None

    def reset(self) -> None:
        """Drop the due ticks after a clock jump."""
        self._last_done = None

    def due(self, now: int) -> range:
        """Return the stamps of the ticks since the last call, up to now [ns]."""
        last = now // self._period
        if self._last_done is None:
            self._last_done = last - 1
        first = max(self._last_done + 1, (now - _BACKLOG_MAX) // self._period + 1)
        self._last_done = max(self._last_done, last)
        return range(first * self._period, last * self._period + 1, self._period)
