"""How a robot with driven wheels moves."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Velocity:
    """Velocity of the base frame in itself.

    Attributes:
        forward: [m/s].
        turn_rate: counterclockwise [rad/s].
    """

    forward: float = 0.0
    turn_rate: float = 0.0

    @property
    def is_standing(self) -> bool:
        """Whether nothing moves."""
        return self.forward == 0.0 and self.turn_rate == 0.0

    def toward(self, wanted: Velocity, forward_step: float, turn_step: float) -> Velocity:
        """Return the velocity next to this one on the way to another.

        Args:
            wanted: where it is to end.
            forward_step: largest change of the speed [m/s].
            turn_step: largest change of the turn rate [rad/s].
        """
        return Velocity(
            _toward(self.forward, wanted.forward, forward_step),
            _toward(self.turn_rate, wanted.turn_rate, turn_step),
        )


def _toward(value: float, wanted: float, step: float) -> float:
    return wanted if abs(wanted - value) <= step else value + math.copysign(step, wanted - value)
