"""What happens on the line, for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass
class LoopReport:
    """State of the line and counts of what went wrong on it.

    Attributes:
        say: is told each new state of the line: one sentence, and whether the robot can be driven.
        state: the latest sentence.
        is_connected: whether a controller answers.
        faults: how often what went wrong.
        connections: how often a controller was found.
    """

    say: Callable[[str, bool], None]
    state: str = 'no controller yet'
    is_connected: bool = False
    faults: Counter[str] = field(default_factory=Counter)
    connections: int = 0

    def connected(self, sentence: str) -> None:
        """A controller answers."""
        self.connections += 1
        self._tell(sentence, is_connected=True)

    def lost(self, sentence: str) -> None:
        """No controller answers any more, or none does yet."""
        self._tell(sentence, is_connected=False)

    def time_went_back(self) -> None:
        """The clock was set or wound back."""
        self.faults['time went back'] += 1
        self.say('time went back: the robot stands, odometry goes on from where it is', False)

    def _tell(self, sentence: str, *, is_connected: bool) -> None:
        if (sentence, is_connected) != (self.state, self.is_connected):
            self.state, self.is_connected = sentence, is_connected
            self.say(sentence, is_connected)
