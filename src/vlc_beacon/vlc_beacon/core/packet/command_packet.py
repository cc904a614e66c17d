"""Command packet.

    kind 2 bits | one-shot 1 bit | operation 5 bits | beacon 16 bits | counter 32 bits | value 32 bits
    | MAC 32 bits of all before | CRC-16 of all before

136 bits. The CRC separates transmission errors from forgeries: only packets with a correct CRC count as authentication
failures. The packet is independent of the key; see `vlc_beacon.core.authorization`.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, replace
from enum import IntEnum

from vlc_beacon.core.packet.crc import crc16
from vlc_beacon.core.packet.id_packet import KIND_SHIFT, PacketKind, check_beacon_id
from vlc_beacon.core.vlc_beacon_error import PacketError


class Operation(IntEnum):
    """Operation codes of the packet. Speeds are in m/s, angles in rad, counterclockwise."""

    STOP = 1
    """Stop until resume; no value."""
    RESUME = 2
    """Resume driving at the cruise speed; no value."""
    SLOW = 3
    """Limit the speed to the value."""
    SPEED_UP = 4
    """Set the speed to the value, bounded by the speed limit."""
    TURN = 5
    """Turn in place by the value."""

    @property
    def label(self) -> str:
        """Name of the operation in topics and files."""
        return self.name.lower()


MAC_BYTES = 4
COMMAND_BYTES = 17
COUNTER_MAX = (1 << 32) - 1
VALUE_STEP = 1e-6
"""Resolution of values: 1 micrometre per second or 1 microradian."""
_BODY = struct.Struct('>BHIi')
_ONE_SHOT = 0x20
_OPERATION_MAX = 0x1F


@dataclass(frozen=True)
class Command:
    """A command sent by a lamp.

    Attributes:
        beacon: ID of the sending lamp.
        operation: operation code, 0 to 31; see `Operation`.
        value: argument in SI units, rounded to `VALUE_STEP`.
        counter: non-decreasing counter against replay, 0 to `COUNTER_MAX`.
        is_one_shot: whether it is executed once, or is a rule of the zone under the lamp.
    """

    beacon: int
    operation: int
    value: float
    counter: int
    is_one_shot: bool = False

    def __post_init__(self) -> None:
        check_beacon_id(self.beacon)
        if not 0 <= self.operation <= _OPERATION_MAX:
            raise PacketError(f'operation is {self.operation}, it must be from 0 to {_OPERATION_MAX}')
        if not 0 <= self.counter <= COUNTER_MAX:
            raise PacketError(f'counter is {self.counter}, it must be from 0 to {COUNTER_MAX}')
        if not math.isfinite(self.value) or abs(self._steps) >= 1 << 31:
            raise PacketError(f'value is {self.value}, its size must be below {VALUE_STEP * (1 << 31):.0f}')

    def signed_bytes(self) -> bytes:
        """Return the bytes that the MAC authenticates."""
        first = PacketKind.COMMAND << KIND_SHIFT | _ONE_SHOT * self.is_one_shot | self.operation
        return _BODY.pack(first, self.beacon, self.counter, self._steps)

    @property
    def _steps(self) -> int:
        return round(self.value / VALUE_STEP)


@dataclass(frozen=True)
class CommandPacket:
    """A command with its message authentication code (MAC) of `MAC_BYTES` bytes, not yet verified."""

    command: Command
    mac: bytes

    def to_bytes(self) -> bytes:
        """Return the packet, `COMMAND_BYTES` long."""
        body = self.command.signed_bytes() + self.mac
        return body + crc16(body).to_bytes(2)


def read_command_packet(data: bytes) -> CommandPacket | None:
    """Parse a command packet; None if length, kind, a field or the checksum is wrong."""
    if len(data) != COMMAND_BYTES or data[0] >> KIND_SHIFT != PacketKind.COMMAND:
        return None
    if crc16(data[:-2]) != int.from_bytes(data[-2:]):
        return None
    first, beacon, counter, value = _BODY.unpack(data[: _BODY.size])
    try:
        command = Command(
            beacon, first & _OPERATION_MAX, round(value * VALUE_STEP, 6), counter, bool(first & _ONE_SHOT)
        )
    except PacketError:
        return None
    return CommandPacket(command, data[_BODY.size : -2])


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
