"""The time, and whether it jumped."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

_BACK_MAX = 100_000_000  # a clock that is set may go back by so much [ns]
_AHEAD_MAX = 10_000_000_000  # simulated time that goes ahead by more was wound on [ns]


class TimeWatch:
    """Asks the node's clock."""

    def __init__(self, node: Node, on_jump: Callable[[], None]) -> None:
        """Begin now.

        Args:
            node: whose clock is asked.
            on_jump: called when time went back, or when simulated time was wound on.
        """
        self._clock, self._on_jump = node.get_clock(), on_jump
        self._is_simulated = bool(node.get_parameter('use_sim_time').value)
        self._latest = 0

    def now(self) -> int:
        """Return the time [ns], 0 while simulated time has not begun."""
        now = int(self._clock.now().nanoseconds)
        before, self._latest = self._latest, now
        wound_on = self._is_simulated and 0 < before < now - _AHEAD_MAX
        if now < before - _BACK_MAX or wound_on:
            self._on_jump()
        return now
