"""Mapping of bytes to symbols, shared by UFSOOK and RS-FSK.

All symbols have equal duration. A packet is a preamble followed by its whitened bits, a fixed number of bits per
symbol, the last symbol padded with zeros. The symbols between two preambles are a packet.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vlc_beacon.core.packet.data_packet import DATA_OVERHEAD, PAYLOAD_MAX

SEQUENCE_BYTES = 512
SKIPPED_BITS = 24
"""Skipped bits of the sequence: it begins with 14 zeros, and so do the packets of most IDs."""


def whiten(data: bytes) -> bytes:
    """XOR with a fixed pseudorandom sequence: long runs of equal symbols become rare. Twice restores the bytes.

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


@dataclass(frozen=True)
class SymbolCode:
    """Mapping of bits to symbols.

    Attributes:
        bits: bits per data symbol; data symbols are 0 to 2^bits - 1.
        preamble: symbols that start a packet; none of them is a data symbol.
        duration: duration of a symbol [s].
    """

    bits: int
    preamble: tuple[int, ...]
    duration: float

    @property
    def symbols_max(self) -> int:
        """Number of data symbols of the longest packet."""
        return -(-8 * (PAYLOAD_MAX + DATA_OVERHEAD) // self.bits)

    @property
    def data_symbols(self) -> int:
        """Number of different data symbols."""
        return 1 << self.bits

    def encode_symbols(self, packet: bytes) -> NDArray[np.int64]:
        """Return the symbols of a packet with its preamble, shape (n,)."""
        bits = np.unpackbits(np.frombuffer(whiten(packet), np.uint8))
        chunks = np.append(bits, np.zeros(-len(bits) % self.bits, np.uint8)).reshape(-1, self.bits)
        return np.concatenate([self.preamble, chunks @ (1 << np.arange(self.bits)[::-1])]).astype(np.int64)

    def decode_symbols(self, symbols: ArrayLike) -> bytes | None:
        """Return the packet of the data symbols between two preambles, shape (n,), or None for incomplete bytes."""
        symbols = np.asarray(symbols, np.int64)
        bits = (symbols[:, None] >> np.arange(self.bits)[::-1] & 1).ravel()
        padding = len(bits) % 8
        if padding >= self.bits or bits[len(bits) - padding :].any():
            return None
        return whiten(np.packbits(bits[: len(bits) - padding]).tobytes())

    def packet_duration(self, packet_bytes: int) -> float:
        """Return the duration of a packet with its preamble [s]."""
        return (len(self.preamble) - (-8 * packet_bytes // self.bits)) * self.duration
