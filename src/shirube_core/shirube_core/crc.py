"""CRC-8 of short packets and lines."""

_POLYNOMIAL = 0x107  # x⁸ + x² + x + 1


def crc8(data: bytes) -> int:
    """Return the CRC-8/SMBUS: it finds every error burst of up to 8 bits, and has Hamming distance 4 up to 119 bits."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc << 1 ^ (_POLYNOMIAL if crc & 0x80 else 0)
    return crc
