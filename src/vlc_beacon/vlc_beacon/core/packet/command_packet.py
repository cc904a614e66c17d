"""Command packet.

    kind 2 bits | one-shot 1 bit | operation 5 bits | beacon 16 bits | counter 32 bits | value 32 bits
    | MAC 32 bits of all before | CRC-16 of all before

136 bits. The CRC separates transmission errors from forgeries: only packets with a correct CRC count as authentication
failures. The packet is independent of the key; see `vlc_beacon.core.authorization`.

The short packet takes a quarter less time, a third for stop and resume. It leaves out what the robot knows:

    kind 2 bits | one-shot 1 bit | short 1 bit | operation 4 bits | counter 32 bits | value 16 bits, or none
    | MAC 32 bits of the complete packet's body | CRC-16 of all before

The beacon is the confirmed ID of the sending lamp. The MAC still authenticates it, and is as long.
"""

import math
import struct
from dataclasses import dataclass, replace
from enum import IntEnum

from vlc_beacon.core.packet.data_packet import KIND_SHIFT, PacketKind, check_beacon_id, crc16
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
_ONE_SHOT, _SHORT = 0x20, 0x10
_OPERATION_MAX = 0x0F
SHORT_STEP, SHORT_STEPS_MAX = 1e-4, (1 << 15) - 1
"""Resolution and range of values in short packets: 0.1 mm/s and 0.1 mrad, up to 3.2767."""
_SHORT_HEAD, _SHORT_VALUE = struct.Struct('>BI'), struct.Struct('>h')
SHORT_BYTES = _SHORT_HEAD.size + _SHORT_VALUE.size + MAC_BYTES + 2
"""Length of a short packet with a value [bytes]."""
WITHOUT_VALUE = (Operation.STOP, Operation.RESUME)
"""Operations whose value is 0 and is not sent in short packets."""


@dataclass(frozen=True)
class Command:
    """A command sent by a lamp.

    Attributes:
        beacon: ID of the sending lamp.
        operation: operation code, 0 to 15; see `Operation`.
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


@dataclass(frozen=True)
class ShortCommandPacket:
    """A command as it is sent without its beacon, which is 0 here, with the MAC of the complete command."""

    command: Command
    mac: bytes

    def to_bytes(self) -> bytes:
        """Return the packet, `command_length` long."""
        command = self.command
        first = PacketKind.COMMAND << KIND_SHIFT | _ONE_SHOT * command.is_one_shot | _SHORT | command.operation
        has_value = command.operation not in WITHOUT_VALUE
        value = _SHORT_VALUE.pack(round(command.value / SHORT_STEP)) if has_value else b''
        body = _SHORT_HEAD.pack(first, command.counter) + value + self.mac
        return body + crc16(body).to_bytes(2)

    def addressed_to(self, beacon: int) -> CommandPacket:
        """Return the complete packet, given the confirmed ID of the lamp that sent this one."""
        return CommandPacket(replace(self.command, beacon=beacon), self.mac)


def shorten(packet: CommandPacket) -> ShortCommandPacket | None:
    """Return the short packet of a command, None if it cannot represent the value."""
    steps = packet.command.value / SHORT_STEP
    is_exact = abs(steps - round(steps)) < 1e-3 and abs(steps) <= SHORT_STEPS_MAX
    if not is_exact or (packet.command.operation in WITHOUT_VALUE and steps != 0.0):
        return None
    return ShortCommandPacket(replace(packet.command, beacon=0), packet.mac)


def command_length(first: int) -> int:
    """Return the length of the command packet that begins with a byte [bytes]."""
    if not first & _SHORT:
        return COMMAND_BYTES
    return SHORT_BYTES - (_SHORT_VALUE.size if first & _OPERATION_MAX in WITHOUT_VALUE else 0)


def read_command_packet(data: bytes) -> CommandPacket | ShortCommandPacket | None:
    """Parse a command packet; None if length, kind, a field or the checksum is wrong."""
    if not data or data[0] >> KIND_SHIFT != PacketKind.COMMAND or len(data) != command_length(data[0]):
        return None
    if crc16(data[:-2]) != int.from_bytes(data[-2:]):
        return None
    operation, is_one_shot, mac = (data[0] & _OPERATION_MAX, bool(data[0] & _ONE_SHOT), data[-2 - MAC_BYTES : -2])
    if data[0] & _SHORT:
        _, counter = _SHORT_HEAD.unpack_from(data)
        value = data[_SHORT_HEAD.size : -2 - MAC_BYTES]
        number = round(_SHORT_VALUE.unpack(value)[0] * SHORT_STEP, 4) if value else 0.0
        return ShortCommandPacket(Command(0, operation, number, counter, is_one_shot), mac)
    _, beacon, counter, steps = _BODY.unpack(data[: _BODY.size])
    try:
        command = Command(beacon, operation, round(steps * VALUE_STEP, 6), counter, is_one_shot)
    except PacketError:
        return None
    return CommandPacket(command, mac)


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
