"""Commands of lamps, as `vlc_beacon` publishes them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

from reward_planner.core.driving.driving_error import DrivingError

OPERATIONS = ('stop', 'resume', 'slow', 'speed_up', 'turn')
_SPEED_OPERATIONS = ('slow', 'speed_up')
_VALUE_OPERATIONS = (*_SPEED_OPERATIONS, 'turn')
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
    """Parse a JSON command.

    Raises:
        DrivingError: not a JSON object, an unknown operation or an invalid value.
    """
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
