"""State of the emergency stop: latched until it is released, with an optional heartbeat."""

import math


class EmergencyStop:
    """Stops from a true until a false, and without messages.

    Attributes:
        is_latched: whether the last message was true.
    """

    def __init__(self, heartbeat: float, *, is_latched: bool) -> None:
        """Start, perhaps still stopped from before a restart; a ``heartbeat`` [s] of 0 is none."""
        self._heartbeat, self.is_latched = heartbeat, is_latched
        self._last_time: float | None = None

    def take(self, now: float, *, is_on: bool) -> None:
        """Take a message, received at a time [s]."""
        self.is_latched, self._last_time = is_on, now

    def reason(self, now: float) -> str:
        """Return why the robot must not drive at a time [s]; empty if it may."""
        if self.is_latched and self._last_time is None:
            return 'stopped by estop before the restart; publish false on estop to release it'
        if self.is_latched:
            return 'stopped by estop'
        age = math.inf if self._last_time is None else now - self._last_time
        if self._heartbeat > 0.0 and not 0.0 <= age <= self._heartbeat:
            return f'stopped, no message on estop for {self._heartbeat:g} s (estop_heartbeat); check its publisher'
        return ''
