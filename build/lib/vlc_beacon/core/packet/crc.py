"""Cyclic redundancy checks of the packets.

CRC-8 is CRC-8/SMBUS and CRC-16 is CRC-16/XMODEM of the catalogue of parametrised CRC algorithms, CRC-32 is that
of Ethernet.
"""

import binascii
import zlib

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
