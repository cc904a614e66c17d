"""Encodes messages given as text tokens to packets.

id            the lamp's ID
text:Hello    text
hex:00ff      bytes
turn:-1.57    a command: an `Operation` with its value in SI units; stop and resume have no value
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.packet.command_packet import (
    SHORT_STEP,
    WITHOUT_VALUE,
    Command,
    Operation,
    find_implausibility,
    shorten,
)
from vlc_beacon.core.packet.data_packet import IdPacket, split_message
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

OPERATIONS = {operation.label: operation for operation in Operation}
_REMEDY = f'use id, text:..., hex:... or a command: {", ".join(OPERATIONS)}'


@dataclass(frozen=True)
class EncoderContext:
    """Sender and signing parameters of messages.

    Attributes:
        beacon: ID of the lamp.
        key: key that signs commands; None without commands.
        counter: counter of the commands, shared by all rules of a lamp.
        is_one_shot: whether commands are executed once, or are rules of the zone under the lamp.
    """

    beacon: int
    key: CommandKey | None = None
    counter: int = 0
    is_one_shot: bool = False


def encode_messages(messages: Sequence[str], context: EncoderContext) -> list[bytes]:
    """Encode messages to packets, in order; raises `VlcBeaconError`.

    Two different one-shot commands share the counter: the second would be rejected as a replay.
    """
    commands = {message for message in messages if message.partition(':')[0] in OPERATIONS}
    if context.is_one_shot and len(commands) > 1:
        raise VlcBeaconError(f'{" and ".join(sorted(commands))}: only one command can be one-shot; choose one')
    for one, other in pairwise(message.partition(':')[0] for message in sorted(commands)):
        if one == other:
            remedy = 'but each rule is executed once per visit; choose one'
            raise VlcBeaconError(f'{one} is given with two values, {remedy}')
    packets = [packet for message in messages for packet in _encode_message(message, context)]
    if not packets:
        raise VlcBeaconError(f'no messages given; {_REMEDY}')
    return packets


def _encode_message(message: str, context: EncoderContext) -> list[bytes]:
    kind, colon, value = message.partition(':')
    if message == 'id':
        return [IdPacket(context.beacon).to_bytes()]
    if kind == 'text' and colon:
        return [packet.to_bytes() for packet in split_message(value)]
    if kind == 'hex' and colon:
        return [packet.to_bytes() for packet in split_message(_parse_hex(message, value))]
    if kind in OPERATIONS:
        return [_encode_command(message, OPERATIONS[kind], value if colon else None, context)]
    raise VlcBeaconError(f'unknown message {message!r}; {_REMEDY}')


def _parse_hex(message: str, digits: str) -> bytes:
    try:
        return bytes.fromhex(digits)
    except ValueError as error:
        raise VlcBeaconError(f'{message}: invalid bytes; give two hexadecimal digits per byte') from error


def _encode_command(message: str, operation: Operation, value: str | None, context: EncoderContext) -> bytes:
    if context.key is None:
        raise VlcBeaconError(f'{message}: a command must be signed; give --key-file')
    number = _parse_value(message, operation, value)
    # Rounded to the resolution of the short packet, unless nothing is left.
    number = round(round(number / SHORT_STEP) * SHORT_STEP, 4) or number
    command = Command(context.beacon, operation, number, context.counter, context.is_one_shot)
    flaw = find_implausibility(command)
    if flaw is not None:
        raise VlcBeaconError(f'{message}: {flaw}, so robots would reject it; choose another value')
    packet = context.key.sign(command)
    return (shorten(packet) or packet).to_bytes()


def _parse_value(message: str, operation: Operation, value: str | None) -> float:
    if operation in WITHOUT_VALUE:
        if value is not None:
            raise VlcBeaconError(f'{message}: {operation.label} has no value; use {operation.label}')
        return 0.0
    try:
        number = float(value or 'nan')
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        example = '-1.5708 (rad)' if operation == Operation.TURN else '0.1 (m/s)'
        raise VlcBeaconError(f'{message}: {operation.label} needs a number; for example {operation.label}:{example}')
    return number
