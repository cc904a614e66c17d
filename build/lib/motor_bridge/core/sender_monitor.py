"""Several senders of velocity commands on one topic."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motor_bridge.core.diff_drive_kinematics import Velocity

MIXED_TIME = 1.0
"""Commands are mixed until none was for this time; a sender that is silent for so long sends no more [s]."""
_NUMBER_STEP_MAX = 20  # so many messages of a publisher may be lost in a row
_SPEED_STEP_MAX = 0.2  # between two messages of one publisher [m/s, rad/s]


@dataclass(frozen=True)
class _Command:
    number: int | None
    velocity: Velocity
    time: float

    def gap(self, after: _Command) -> float:
        """Return how far another command is from this one; infinite if it cannot be the next one of its sender."""
        if self.number is not None and after.number is not None:
            gap: float = after.number - self.number
            return gap if 0 < gap <= _NUMBER_STEP_MAX else math.inf
        a, b = self.velocity, after.velocity
        gap = max(abs(a.forward - b.forward), abs(a.turn_rate - b.turn_rate))
        return gap if gap <= _SPEED_STEP_MAX else math.inf


class SenderMonitor:
    """Notices when the commands of several senders are interleaved, though messages do not name their sender.

    A publisher numbers its messages, so each continues a row of numbers or begins one. Commands are mixed if one
    continues a row that is not the latest: A, B, A. One publisher after another is not mixed. Where the middleware does
    not pass on the numbers, a row is one of similar velocities.
    """

    def __init__(self) -> None:
        """Start without commands."""
        self._rows: list[_Command] = []  # the last command of each sender, the latest one last
        self._mixed_time = -math.inf

    def take(self, number: int | None, velocity: Velocity, now: float) -> None:
        """Take a command that was received at a time [s]; its number may not be known."""
        command = _Command(number, velocity, now)
        rows = [row for row in self._rows if 0.0 <= now - row.time <= MIXED_TIME]
        candidates = [row for row in reversed(rows) if row.gap(command) < math.inf]
        if candidates:
            continued = min(candidates, key=lambda row: row.gap(command))
            if continued is not rows[-1]:
                self._mixed_time = now
            rows.remove(continued)
        self._rows = [*rows, command]

    def is_mixed(self, now: float) -> bool:
        """Return whether commands were mixed shortly before a time [s]."""
        return 0.0 <= now - self._mixed_time <= MIXED_TIME
