"""State of the lamps' commands: stop, speed limit and turn."""

from __future__ import annotations

import math

from reward_planner.core.driving.light_command import LightCommand
from shirube_geometry import wrap_angle


class LightOrders:
    """Commands of lamps that are in effect.

    Attributes:
        is_stopped: whether a stop command is in effect.
        speed_limit: maximum speed [m/s].
        remaining_turn: remaining angle to turn in place, counterclockwise [rad], 0 for none; may exceed half a turn.
    """

    def __init__(self, speed_max: float) -> None:
        """Start without commands, with the robot's maximum speed [m/s]."""
        self.is_stopped = False
        self.speed = speed_max
        self.left_to_turn = 0.0
        self._speed_max = speed_max
        self._yaw = math.nan

    def obey(self, command: LightCommand) -> None:
        """Apply a command."""
        match command.operation:
            case 'stop':
                self.is_stopped = True
            case 'resume':
                self.is_stopped, self.speed = False, self._speed_max
            case 'slow':
                self.speed = min(self.speed, command.value)
            case 'speed_up':
                self.speed = min(command.value, self._speed_max)
            case 'turn':
                self.left_to_turn = max(-math.tau, min(self.left_to_turn + command.value, math.tau))

    def robot_heads(self, yaw: float) -> None:
        """Update the remaining turn with the robot's heading in the map [rad]."""
        if self.left_to_turn != 0.0 and math.isfinite(self._yaw):
            self.left_to_turn -= wrap_angle(yaw - self._yaw)
        self._yaw = yaw

    def end_turn(self) -> None:
        """End the turn; the next heading may be unrelated to the last."""
        self.left_to_turn, self._yaw = 0.0, math.nan
