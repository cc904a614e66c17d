"""Velocity of a differential-drive robot."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Velocity:
    """Velocity of the base frame, expressed in the base frame.

    Attributes:
        forward: forward speed [m/s].
        turn_rate: yaw rate, counterclockwise [rad/s].
    """

    forward: float = 0.0
    turn_rate: float = 0.0

    @property
    def is_zero(self) -> bool:
        """Whether both components are zero."""
        return self.forward == 0.0 and self.turn_rate == 0.0

    def step_toward(self, target: Velocity, forward_step: float, turn_step: float) -> Velocity:
        """Return this velocity moved towards a target by at most one step.

        Args:
            target: target velocity.
            forward_step: maximum change of the forward speed [m/s].
            turn_step: maximum change of the yaw rate [rad/s].
        """
        return Velocity(
            _step_toward(self.forward, target.forward, forward_step),
            _step_toward(self.turn_rate, target.turn_rate, turn_step),
        )


def _step_toward(value: float, target: float, step: float) -> float:
    return target if abs(target - value) <= step else value + math.copysign(step, target - value)
