"""The node's clock, with detection of jumps."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

_JUMP_BACK_MIN = 100_000_000  # tolerated step back when a clock is synchronized [ns]
_JUMP_AHEAD_MIN = 10_000_000_000  # a larger step ahead of simulated time is a jump [ns]


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
