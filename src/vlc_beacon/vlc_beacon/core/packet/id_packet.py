"""ID packet: identifies the lamp.

    kind 2 bits | ID 14 bits | CRC-8 of both bytes

24 bits: 0.8 s at 30 bit/s, plus two bit times of the preamble.
"""

import binascii
import zlib
from dataclasses import dataclass
from enum import IntEnum

from vlc_beacon.core.vlc_beacon_error import PacketError

CRC8_POLYNOMIAL = 0x07


def crc8(data: bytes) -> int:
    """Return the CRC-8/SMBUS of bytes: Hamming distance 4 up to 119 bits."""
    value = 0
    for byte in data:
        value = _CRC8_TABLE[value ^ byte]
    return value


def crc16(data: bytes) -> int:
    """Return the CRC-16/XMODEM of bytes: Hamming distance 4 up to 32751 bits."""
    return binascii.crc_hqx(data, 0)


def crc32(data: bytes) -> int:
    """Return the CRC-32 of Ethernet of bytes."""
    return zlib.crc32(data)


def _crc8_table() -> list[int]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = (value << 1 ^ (CRC8_POLYNOMIAL if value & 0x80 else 0)) & 0xFF  # noqa: PLW2901
        table.append(value)
    return table


_CRC8_TABLE = _crc8_table()


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
