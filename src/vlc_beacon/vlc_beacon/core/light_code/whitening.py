"""Makes any content look like chance, so that long runs of equal symbols, which hide the symbols' beat and which
the eye could see, are as rare as in chance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LENGTH = 512
SKIPPED = 24
"""Bits of the register's sequence that are left out: it begins with 14 zeros, and so do the packets of most IDs."""


def whiten(data: bytes) -> bytes:
    """Add a fixed sequence to bytes modulo 2; a second time takes it away again.

    The sequence is that of the shift register x^15 + x^14 + 1, from all ones, as used by ITU-T O.151, but for its
    beginning.
    """
    sequence = np.tile(_SEQUENCE, 1 + len(data) // LENGTH)[: len(data)]
    return (np.frombuffer(data, np.uint8) ^ sequence).tobytes()


def _shift_register_bytes() -> NDArray[np.uint8]:
    state, bits = 0x7FFF, []
    for _ in range(SKIPPED + 8 * LENGTH):
        bit = (state >> 14 ^ state >> 13) & 1
        state = (state << 1 | bit) & 0x7FFF
        bits.append(bit)
    return np.packbits(bits[SKIPPED:])


_SEQUENCE = _shift_register_bytes()
