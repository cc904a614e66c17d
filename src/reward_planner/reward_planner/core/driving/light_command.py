"""Commands that lamps give, as `vlc_beacon` publishes them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

from reward_planner.core.driving.driving_error import DrivingError

OPERATIONS = ('stop', 'resume', 'slow', 'speed_up', 'turn')
_WITH_SPEED = ('slow', 'speed_up')
_WITH_VALUE = (*_WITH_SPEED, 'turn')
_LARGEST = 1000.0
_TURN_MAX = math.tau + 1e-6


@dataclass(frozen=True)
class LightCommand:
    """What a lamp asks for.

    Attributes:
        operation: one of OPERATIONS.
        value: a speed [m/s] of slow and speed_up, an angle [rad] of turn, counterclockwise; else without meaning.
    """

    operation: str
    value: float


def read_light_command(text: str) -> LightCommand:
    """Return the command that a JSON text holds.

    Raises:
        DrivingError: no JSON object, an operation that does not exist, or a value that is none.
    """
    try:
        fields = json.loads(text)
    except (ValueError, RecursionError) as fault:
        raise DrivingError('command is no JSON; send beacon, counter, op and value') from fault
    operation = fields.get('op') if isinstance(fields, dict) else None
    if operation not in OPERATIONS:
        raise DrivingError(f'command has no known op; it must be one of {", ".join(OPERATIONS)}')
    value = fields.get('value', None if operation in _WITH_VALUE else 0.0)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _LARGEST:
        raise DrivingError('command has a value that is no finite number of a sensible size; send one')
    if operation in _WITH_SPEED and value < 0.0:
        raise DrivingError(f'command {operation} has a negative speed; send 0 or more')
    if operation == 'turn' and abs(value) > _TURN_MAX:
        raise DrivingError(f'command turn asks for {value:g} rad; send a whole turn at most')
    return LightCommand(operation, float(value))
