"""State of the lamps' commands: stop, speed limit and turn."""

from __future__ import annotations

import math

from reward_planner.core.driving.light_command import LightCommand
from shirube_core.geometry import wrap_angle


class LightCommandState:
    """Commands of lamps that are in effect.

    Attributes:
        is_stopped: whether a stop command is in effect.
        speed_limit: maximum speed [m/s].
        remaining_turn: remaining angle to turn in place, counterclockwise [rad], 0 for none; may exceed half a turn.
    """

    def __init__(self, speed_max: float) -> None:
        """Start without commands, with the robot's maximum speed [m/s]."""
        self.is_stopped = False
        self.speed_limit = speed_max
        self.remaining_turn = 0.0
        self._speed_max = speed_max
        self._yaw = math.nan

    def apply_command(self, command: LightCommand) -> None:
        """Apply a command."""
        match command.operation:
            case 'stop':
                self.is_stopped = True
            case 'resume':
                self.is_stopped, self.speed_limit = False, self._speed_max
            case 'slow':
                self.speed_limit = min(self.speed_limit, command.value)
            case 'speed_up':
                self.speed_limit = min(command.value, self._speed_max)
            case 'turn':
                self.remaining_turn = max(-math.tau, min(self.remaining_turn + command.value, math.tau))

    def update_heading(self, yaw: float) -> None:
        """Update the remaining turn with the robot's heading in the map [rad]."""
        if self.remaining_turn != 0.0 and math.isfinite(self._yaw):
            self.remaining_turn -= wrap_angle(yaw - self._yaw)
        self._yaw = yaw

    def cancel_turn(self) -> None:
        """End the turn; the next heading may be unrelated to the last."""
        self.remaining_turn, self._yaw = 0.0, math.nan
