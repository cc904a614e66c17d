"""The node's clock: detection of jumps, and output stamps at a fixed rate."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

_JUMP_BACK_MIN = 100_000_000  # tolerated step back when a clock is synchronized [ns]
_JUMP_AHEAD_MIN = 10_000_000_000  # a larger step ahead of simulated time is a jump [ns]
_BACKLOG_MAX = 500_000_000  # older ticks are dropped [ns]


class ClockMonitor:
    """Reads the node's clock and reports jumps."""

    def __init__(self, node: Node, on_jump: Callable[[], None]) -> None:
        """Start with the clock of a node.

        Args:
            node: node whose clock is read.
            on_jump: called when time jumped back, or when simulated time jumped ahead.
        """
        self._clock, self._on_jump = node.get_clock(), on_jump
        self._is_simulated = bool(node.get_parameter('use_sim_time').value)
        self._latest = 0

    def now(self) -> int:
        """Return the current time [ns], 0 before simulated time has started."""
        now = int(self._clock.now().nanoseconds)
        before, self._latest = self._latest, now
        jumped_ahead = self._is_simulated and 0 < before < now - _JUMP_AHEAD_MIN
        if now < before - _JUMP_BACK_MIN or jumped_ahead:
            self._on_jump()
        return now


class TickSchedule:
    """Ticks at multiples of the period, none skipped under load; integers, so that they do not drift."""

    def __init__(self, rate: float) -> None:
        """Start at the first call of `due`, with a tick rate [1/s]."""
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
