"""What lamps have said that still holds: whether to stand, how fast to drive, how far to turn."""

from __future__ import annotations

import math

from reward_planner.core.driving.light_command import LightCommand
from shirube_geometry import wrap_angle


class LightOrders:
    """The standing orders of the lamps.

    Attributes:
        is_stopped: a lamp said stop, and none resume since.
        speed: no faster than this [m/s].
        left_to_turn: angle that is still to be turned on the spot [rad], 0 for none; more than half a turn goes the
            long way round.
    """

    def __init__(self, speed_max: float) -> None:
        """Begin without orders, at the robot's greatest speed [m/s]."""
        self.is_stopped = False
        self.speed = speed_max
        self.left_to_turn = 0.0
        self._speed_max = speed_max
        self._yaw = math.nan

    def obey(self, command: LightCommand) -> None:
        """Take a command."""
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
        """Take the robot's heading in the map [rad]."""
        if self.left_to_turn != 0.0 and math.isfinite(self._yaw):
            self.left_to_turn -= wrap_angle(yaw - self._yaw)
        self._yaw = yaw

    def end_turn(self) -> None:
        """The turn is done, or given up; the next heading may be any other."""
        self.left_to_turn, self._yaw = 0.0, math.nan
