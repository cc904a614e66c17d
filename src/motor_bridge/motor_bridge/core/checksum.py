"""Checksum of the text lines of firmware/motor_controller."""

_POLYNOMIAL = 0x107  # x⁸ + x² + x + 1


def crc8(data: bytes) -> int:
    """Return the CRC-8 with polynomial 0x07 and initial value 0: it finds every error burst of up to 8 bits."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc << 1 ^ (_POLYNOMIAL if crc & 0x80 else 0)
    return crc


def with_checksum(text: bytes) -> bytes:
    """Return a line without its end, followed by ``*`` and its checksum as two hexadecimal digits."""
    return text + b'*%02X' % crc8(text)


def without_checksum(line: bytes) -> bytes | None:
    """Return the text before a valid checksum, or None."""
    text = line.rpartition(b'*')[0]
    return text if line == with_checksum(text) else None
