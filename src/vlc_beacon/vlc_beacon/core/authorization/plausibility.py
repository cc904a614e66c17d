"""Limits of command values."""

from __future__ import annotations

import math
from dataclasses import replace

from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.operation import Operation

TURN_MAX = 2.0 * math.pi
"""Maximum commanded turn [rad]."""


def find_implausibility(command: Command) -> str | None:
    """Return why operation or value is implausible, or None."""
    if command.operation not in set(Operation):
        return f'operation {command.operation} is unknown'
    operation = Operation(command.operation)
    match operation:
        case Operation.STOP | Operation.RESUME:
            is_good = command.value == 0.0
        case Operation.SLOW | Operation.SPEED_UP:
            is_good = command.value > 0.0
        case Operation.TURN:
            is_good = abs(command.value) <= TURN_MAX
    return None if is_good else f'{operation.label} cannot have the value {command.value:g}'


def clamp_speed(command: Command, speed_limit: float) -> Command:
    """Return the command with its speed limited [m/s]; other commands are unchanged."""
    if command.operation in (Operation.SLOW, Operation.SPEED_UP):
        return replace(command, value=min(command.value, speed_limit))
    return command
