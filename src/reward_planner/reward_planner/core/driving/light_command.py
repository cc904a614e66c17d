"""Commands of lamps, as `vlc_beacon` publishes them, and those that are in effect."""

import json
import math
from dataclasses import dataclass

from reward_planner.core.driving.path_following import turn_rate_for_angle
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import wrap_angle

OPERATIONS = ('stop', 'resume', 'slow', 'speed_up', 'turn')
_SPEED_OPERATIONS = ('slow', 'speed_up')
_VALUE_OPERATIONS = (*_SPEED_OPERATIONS, 'turn')
_TURN_TOLERANCE = 0.02  # tolerance of a commanded turn [rad]
_VALUE_MAX = 1000.0
_TURN_MAX = math.tau + 1e-6


@dataclass(frozen=True)
class LightCommand:
    """Command of a lamp.

    Attributes:
        operation: one of OPERATIONS.
        value: speed of slow and speed_up [m/s], counterclockwise angle of turn [rad]; unused otherwise.
    """

    operation: str
    value: float


def parse_light_command(text: str) -> LightCommand:
    """Parse a JSON command; raise a DrivingError if it is not one, or has an unknown operation or an invalid value."""
    try:
        fields = json.loads(text)
    except (ValueError, RecursionError) as fault:
        raise DrivingError('command is not valid JSON; send beacon, counter, op and value') from fault
    operation = fields.get('op') if isinstance(fields, dict) else None
    if operation not in OPERATIONS:
        raise DrivingError(f'command has an unknown op; it must be one of {", ".join(OPERATIONS)}')
    value = fields.get('value', None if operation in _VALUE_OPERATIONS else 0.0)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _VALUE_MAX:
        raise DrivingError(f'command has a value that is not a number of at most {_VALUE_MAX:g}; send one')
    if operation in _SPEED_OPERATIONS and value < 0.0:
        raise DrivingError(f'command {operation} has a negative speed; send 0 or more')
    if operation == 'turn' and abs(value) > _TURN_MAX:
        raise DrivingError(f'command turn has an angle of {value:g} rad; send at most one full turn')
    return LightCommand(operation, float(value))


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

    def set_speed_max(self, speed_max: float) -> None:
        """Change the robot's maximum speed [m/s]; a lower limit that a lamp set stays."""
        was_free, self._speed_max = self.speed_limit >= self._speed_max, speed_max
        self.speed_limit = speed_max if was_free else min(self.speed_limit, speed_max)

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

    def turn_rate(self, settings: DrivingSettings, *, is_stopped: bool) -> float:
        """Return the turn rate for the remaining turn [rad/s]; a robot that is stopped within a tolerance ends it."""
        if is_stopped and abs(self.remaining_turn) <= _TURN_TOLERANCE:
            self.cancel_turn()
        return turn_rate_for_angle(self.remaining_turn, settings)

    def cancel_turn(self) -> None:
        """End the turn; the next heading may be unrelated to the last."""
        self.remaining_turn, self._yaw = 0.0, math.nan
