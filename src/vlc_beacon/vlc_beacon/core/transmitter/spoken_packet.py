"""Words that tell what a lamp shall say, to packets.

id            the lamp's ID
text:Hello    text
hex:00ff      bytes
turn:-1.57    a command, an `Operation` with its value in SI units; stop and resume have none
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.data_packet import packets_of_message
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.plausibility import implausibility
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

OPERATIONS = {operation.word: operation for operation in Operation}
_WITHOUT_VALUE = (Operation.STOP, Operation.RESUME)
_REMEDY = f'say id, text:..., hex:... or a command: {", ".join(OPERATIONS)}'


@dataclass(frozen=True)
class Speaker:
    """Who speaks, and with what right.

    Attributes:
        beacon: ID of the lamp.
        key: signs commands; None where none is at hand.
        counter: of its commands, which all rules of a lamp share.
        is_one_shot: whether a command is to be done once, or is a rule of the zone under the lamp.
    """

    beacon: int
    key: CommandKey | None = None
    counter: int = 0
    is_one_shot: bool = False


def packets_of_words(words: Sequence[str], speaker: Speaker) -> list[bytes]:
    """Return the packets that words stand for, in their order.

    Raises:
        VlcBeaconError: a word that means nothing, a command without a key or a value, one operation with two
            values, or two different one-shot commands: they share the counter, so the robot would take the second for
            a replay.
    """
    commands = {word for word in words if word.partition(':')[0] in OPERATIONS}
    if speaker.is_one_shot and len(commands) > 1:
        raise VlcBeaconError(f'{" and ".join(sorted(commands))}: only one of them can be one-shot; choose it')
    operations = [word.partition(':')[0] for word in sorted(commands)]
    for operation in operations:
        if operations.count(operation) > 1:
            raise VlcBeaconError(
                f'{operation} is there with two values, but a robot does each rule once a visit; choose one'
            )
    packets = [packet for word in words for packet in _packets(word, speaker)]
    if not packets:
        raise VlcBeaconError(f'the lamp has nothing to say; {_REMEDY}')
    return packets


def _packets(word: str, speaker: Speaker) -> list[bytes]:
    kind, colon, value = word.partition(':')
    if word == 'id':
        return [IdPacket(speaker.beacon).to_bytes()]
    if kind == 'text' and colon:
        return [packet.to_bytes() for packet in packets_of_message(value)]
    if kind == 'hex' and colon:
        return [packet.to_bytes() for packet in packets_of_message(_bytes_of(word, value))]
    if kind in OPERATIONS:
        return [_command(word, OPERATIONS[kind], value if colon else None, speaker)]
    raise VlcBeaconError(f'{word!r} means nothing; {_REMEDY}')


def _bytes_of(word: str, digits: str) -> bytes:
    try:
        return bytes.fromhex(digits)
    except ValueError as error:
        raise VlcBeaconError(f'{word}: is no row of bytes; give two hexadecimal digits for each') from error


def _command(word: str, operation: Operation, value: str | None, speaker: Speaker) -> bytes:
    if speaker.key is None:
        raise VlcBeaconError(f'{word}: a command must be signed; give --key-file')
    number = _value(word, operation, value)
    command = Command(speaker.beacon, operation, number, speaker.counter, speaker.is_one_shot)
    flaw = implausibility(command)
    if flaw is not None:
        raise VlcBeaconError(f'{word}: {flaw}, so no robot would obey it; choose another value')
    return speaker.key.sign(command).to_bytes()


def _value(word: str, operation: Operation, value: str | None) -> float:
    if operation in _WITHOUT_VALUE:
        if value is not None:
            raise VlcBeaconError(f'{word}: {operation.word} has no value; say {operation.word}')
        return 0.0
    try:
        number = float(value or 'nan')
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        example = '-1.5708 (rad)' if operation == Operation.TURN else '0.1 (m/s)'
        raise VlcBeaconError(
            f'{word}: {operation.word} needs a number; for example {operation.word}:{example}'
        )
    return number
