"""Data whitening: makes long runs of equal symbols, which prevent symbol timing recovery and flicker visibly, as
rare as in random data.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SEQUENCE_BYTES = 512
SKIPPED_BITS = 24
"""Skipped bits of the sequence: it begins with 14 zeros, and so do the packets of most IDs."""


def whiten(data: bytes) -> bytes:
    """XOR the bytes with a fixed pseudorandom sequence; applying it twice restores them.

    The sequence is that of the shift register x^15 + x^14 + 1 (ITU-T O.151), initialized with ones, without its first
    bits.
    """
    sequence = np.tile(_SEQUENCE, 1 + len(data) // SEQUENCE_BYTES)[: len(data)]
    return (np.frombuffer(data, np.uint8) ^ sequence).tobytes()


def _shift_register_bytes() -> NDArray[np.uint8]:
    state, bits = 0x7FFF, []
    for _ in range(SKIPPED_BITS + 8 * SEQUENCE_BYTES):
        bit = (state >> 14 ^ state >> 13) & 1
        state = (state << 1 | bit) & 0x7FFF
        bits.append(bit)
    return np.packbits(bits[SKIPPED_BITS:])


_SEQUENCE = _shift_register_bytes()
