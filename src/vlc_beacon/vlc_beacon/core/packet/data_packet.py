"""Data packet with text or bytes.

    kind 2 bits | text 1 bit | last 1 bit | tag 4 bits | sequence 8 bits | length 8 bits
    | payload | CRC-32 of all before

A message longer than a packet is fragmented; fragments are numbered from 0 and the last one is flagged. They share a
tag computed from the message, so that fragments of different messages are not mixed.
"""

import binascii
import zlib
from dataclasses import dataclass
from enum import IntEnum

from shirube_core.crc import crc8
from vlc_beacon.core.vlc_beacon_error import PacketError


def crc16(data: bytes) -> int:
    """Return the CRC-16/XMODEM of bytes: Hamming distance 4 up to 32751 bits."""
    return binascii.crc_hqx(data, 0)


def crc32(data: bytes) -> int:
    """Return the CRC-32 of Ethernet of bytes."""
    return zlib.crc32(data)


KIND_SHIFT = 6
"""The kind is in the two highest bits of the first byte; 0 is invalid, so that darkness is not a packet."""


class PacketKind(IntEnum):
    """Kind of a packet."""

    ID = 1
    DATA = 2
    COMMAND = 3


BEACON_ID_MAX = (1 << 14) - 1
ID_BYTES = 3


@dataclass(frozen=True)
class IdPacket:
    """The ID of a lamp, 0 to `BEACON_ID_MAX`."""

    beacon: int

    def __post_init__(self) -> None:
        check_beacon_id(self.beacon)

    def to_bytes(self) -> bytes:
        """Return the packet, `ID_BYTES` long."""
        body = (PacketKind.ID << 14 | self.beacon).to_bytes(2)
        return body + bytes([crc8(body)])


def read_id_packet(data: bytes) -> IdPacket | None:
    """Parse an ID packet; None if length, kind or checksum is wrong."""
    if len(data) != ID_BYTES or data[0] >> KIND_SHIFT != PacketKind.ID or crc8(data[:2]) != data[2]:
        return None
    return IdPacket(int.from_bytes(data[:2]) & BEACON_ID_MAX)


def check_beacon_id(beacon: int) -> None:
    """Check the range of an ID; raises `PacketError`."""
    if not 0 <= beacon <= BEACON_ID_MAX:
        raise PacketError(f'beacon ID is {beacon}, it must be from 0 to {BEACON_ID_MAX}')


PAYLOAD_MAX = 100
DATA_OVERHEAD = 7
"""Bytes of a packet without its payload."""
TAG_MAX = 0x0F
_TEXT, _LAST = 0x20, 0x10


@dataclass(frozen=True)
class DataPacket:
    """A fragment of a message.

    Attributes:
        payload: payload of up to `PAYLOAD_MAX` bytes.
        sequence: number of the fragment, 0 to 255.
        is_last: whether it is the last fragment.
        is_text: whether the message is text in UTF-8.
        tag: tag of the message, 0 to `TAG_MAX`.
    """

    payload: bytes
    sequence: int = 0
    is_last: bool = True
    is_text: bool = False
    tag: int = 0

    def __post_init__(self) -> None:
        if len(self.payload) > PAYLOAD_MAX:
            raise PacketError(f'payload has {len(self.payload)} bytes, a packet holds up to {PAYLOAD_MAX}')
        if not 0 <= self.sequence <= 255:
            raise PacketError(f'sequence number is {self.sequence}, it must be from 0 to 255')
        if not 0 <= self.tag <= TAG_MAX:
            raise PacketError(f'tag is {self.tag}, it must be from 0 to {TAG_MAX}')

    def to_bytes(self) -> bytes:
        """Return the packet."""
        first = PacketKind.DATA << KIND_SHIFT | _TEXT * self.is_text | _LAST * self.is_last | self.tag
        body = bytes([first, self.sequence, len(self.payload)]) + self.payload
        return body + crc32(body).to_bytes(4)


def read_data_packet(data: bytes) -> DataPacket | None:
    """Parse a data packet; None if kind, length or checksum is wrong."""
    if len(data) < DATA_OVERHEAD or data[0] & ~(_TEXT | _LAST | TAG_MAX) != PacketKind.DATA << KIND_SHIFT:
        return None
    if len(data) != DATA_OVERHEAD + data[2] or data[2] > PAYLOAD_MAX:
        return None
    if crc32(data[:-4]) != int.from_bytes(data[-4:]):
        return None
    return DataPacket(data[3:-4], data[1], bool(data[0] & _LAST), bool(data[0] & _TEXT), data[0] & TAG_MAX)


def split_message(message: bytes | str) -> list[DataPacket]:
    """Split a message, text as UTF-8, into packets; raises `PacketError` if there are more than 256."""
    content = message.encode() if isinstance(message, str) else message
    parts = [content[i : i + PAYLOAD_MAX] for i in range(0, len(content), PAYLOAD_MAX)] or [b'']
    if len(parts) > 256:
        raise PacketError(f'message has {len(content)} bytes, up to {256 * PAYLOAD_MAX} can be sent')
    last, tag = len(parts) - 1, crc8(content) & TAG_MAX
    return [DataPacket(part, i, i == last, isinstance(message, str), tag) for i, part in enumerate(parts)]


class MessageAssembler:
    """Reassembles fragmented messages; lamps repeat them, so a missed fragment is received later."""

    def __init__(self) -> None:
        self._parts: dict[int, DataPacket] = {}
        self._last_message: str | bytes | None = None

    def add(self, packet: DataPacket) -> str | bytes | None:
        """Add a fragment and return the completed message; None if incomplete or equal to the last one."""
        if not all(_are_compatible(part, packet) for part in self._parts.values()):
            self._parts.clear()
        self._parts[packet.sequence] = packet
        last = next((part.sequence for part in self._parts.values() if part.is_last), None)
        if last is None or any(number not in self._parts for number in range(last + 1)):
            return None
        content = b''.join(self._parts[number].payload for number in range(last + 1))
        message = content.decode(errors='replace') if packet.is_text else content
        if message == self._last_message:
            return None
        self._last_message = message
        return message


def _are_compatible(one: DataPacket, other: DataPacket) -> bool:
    if (one.tag, one.is_text) != (other.tag, other.is_text):
        return False
    if one.sequence == other.sequence:
        return one == other
    earlier = one if one.sequence < other.sequence else other
    return not earlier.is_last
