"""State and faults of the serial link, for logs and diagnostics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass
class LinkReport:
    """State of the serial link and its fault counters.

    Attributes:
        log: called with each new state: one line, and whether the controller is connected.
        state: latest state, one line.
        is_connected: whether the controller is connected.
        faults: number of faults by kind.
        connections: number of successful handshakes.
    """

    log: Callable[[str, bool], None]
    state: str = 'no controller yet'
    is_connected: bool = False
    faults: Counter[str] = field(default_factory=Counter)
    connections: int = 0

    def set_connected(self, message: str) -> None:
        """Report a successful handshake."""
        self.connections += 1
        self._set_state(message, is_connected=True)

    def set_disconnected(self, message: str) -> None:
        """Report a lost or missing connection."""
        self._set_state(message, is_connected=False)

    def count_time_jump(self) -> None:
        """Report that the clock jumped back."""
        self.faults['clock jumped back'] += 1
        self.log('clock jumped back: the robot stops, odometry continues from the current pose', False)

    def _set_state(self, message: str, *, is_connected: bool) -> None:
        if (message, is_connected) != (self.state, self.is_connected):
            self.state, self.is_connected = message, is_connected
            self.log(message, is_connected)
