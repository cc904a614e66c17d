"""Manchester code in repeated segments, for rolling shutters and lamps that cover many rows.

A packet becomes a whitened Reed-Solomon block ``number of segments | packet | zeros | parity``, a seventh of it
parity, which is split into numbered segments. A segment is

    preamble 111000 | index 7 bits | bytes of the block | CRC-4

in chips, a bit 1 as 10 and a bit 0 as 01; three equal chips in a row occur only in the preamble. A segment is repeated
until the slowest camera has seen it completely: any window of one segment length contains all of its chips, cyclically
shifted. No frame synchronization is needed. Segments that are missed, because frames were dropped or spanned a segment
change, are erasures of the block.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from reedsolo import ReedSolomonError, RSCodec

from shirube_core.waveform import Waveform, waveform_from_steps
from vlc_beacon.core.light_code.symbol_code import whiten
from vlc_beacon.core.packet.packet_reader import Packet, packet_length, read_packet
from vlc_beacon.core.vlc_beacon_error import PacketError, VlcBeaconError

PREAMBLE = (1, 1, 1, 0, 0, 0)
INDEX_BITS = 7
CRC_BITS = 4
CRC_POLYNOMIAL = 0b10011
"""x^4 + x + 1, as in CRC-4/INTERLAKEN but with initial value 0."""
CHIP_TIMES = (1.0 / 8000.0, 1.0 / 6000.0)
"""Shortest and longest chip [s]: limited by rolling shutters and by visible flicker of the segments."""
SEGMENT_BYTES_MAX = 8
"""Limit for the shortest chips; see `REPETITION_MAX`."""
REPETITION_MAX = 0.02
"""Maximum duration of a segment, so that its repetitions do not flicker visibly [s]."""


@dataclass(frozen=True)
class SegmentFormat:
    """Format of the segments of a block.

    Attributes:
        segment_bytes: bytes of the block per segment: more bytes need more rows and reduce overhead.
        chip_time: duration of a chip [s], within `CHIP_TIMES`.
        frame_rate: frame rate of the slowest camera [1/s].
    """

    segment_bytes: int = 1
    chip_time: float = 1.0 / 8000.0
    frame_rate: float = 30.0

    def __post_init__(self) -> None:
        if not CHIP_TIMES[0] <= self.chip_time <= CHIP_TIMES[1]:
            low, high = CHIP_TIMES
            raise VlcBeaconError(f'chip_time is {self.chip_time:g} s, it must be from {low:g} to {high:g} s')
        if self.segment_bytes < 1 or self.chips * self.chip_time > REPETITION_MAX:
            chips = int(REPETITION_MAX / self.chip_time + 1e-6)
            most = ((chips - len(PREAMBLE)) // 2 - INDEX_BITS - CRC_BITS) // 8
            raise VlcBeaconError(
                f'segment_bytes is {self.segment_bytes}, it must be from 1 to {most}, or the lamp would flicker visibly'
            )

    @property
    def bits(self) -> int:
        """Bits of a segment after its preamble."""
        return INDEX_BITS + 8 * self.segment_bytes + CRC_BITS

    @property
    def chips(self) -> int:
        """Chips of a segment."""
        return len(PREAMBLE) + 2 * self.bits

    @property
    def repeats(self) -> int:
        """Number of repetitions of a segment."""
        return 1 + math.ceil((1.0 / self.frame_rate / self.chip_time + 2.0) / self.chips)

    @property
    def segment_seconds(self) -> float:
        """Duration of a segment with its repetitions [s]."""
        return self.repeats * self.chips * self.chip_time

    def rows_min(self, row_time: float, exposure: float) -> int:
        """Return the minimum number of rows of a lamp, for a camera's line time and exposure [s]."""
        return math.ceil(((self.chips + 1) * self.chip_time + exposure) / row_time)


@dataclass(frozen=True)
class Segment:
    """A segment of a block with its index in the block, 0 to 127."""

    index: int
    content: bytes

    def chips(self) -> NDArray[np.uint8]:
        """Return the chips, shape (n,), 0 and 1."""
        content = np.unpackbits(np.frombuffer(self.content, np.uint8))
        bits = np.concatenate([_int_to_bits(self.index, INDEX_BITS), content])
        bits = np.append(bits, _int_to_bits(_crc4(bits), CRC_BITS))
        return np.append(np.array(PREAMBLE, np.uint8), np.column_stack([bits, 1 - bits]).ravel())


def segment_from_bits(bits: NDArray[np.uint8]) -> Segment | None:
    """Return the segment of the bits after a preamble, shape (bits,), or None if its CRC is wrong."""
    if (bits @ _crc4_matrix(len(bits)) % 2).any():
        return None
    content = np.packbits(bits[INDEX_BITS:-CRC_BITS]).tobytes()
    index = int(bits[:INDEX_BITS] @ (1 << np.arange(INDEX_BITS)[::-1]))
    return Segment(index, content)


def segments_waveform(segments: list[Segment], segment_format: SegmentFormat, clock_scale: float = 1.0) -> Waveform:
    """Return the periodic waveform of segments, each repeated; ``clock_scale`` simulates a clock error."""
    chips = np.concatenate([np.tile(segment.chips(), segment_format.repeats) for segment in segments])
    return waveform_from_steps(np.full(len(chips), segment_format.chip_time * clock_scale), chips)


def _int_to_bits(number: int, count: int) -> NDArray[np.uint8]:
    return (number >> np.arange(count)[::-1] & 1).astype(np.uint8)


def _crc4(bits: NDArray[np.uint8]) -> int:
    """Return the CRC-4 of the bits."""
    value = 0
    for bit in bits.tolist():
        value = value << 1 ^ (bit << CRC_BITS)
        if value >> CRC_BITS:
            value ^= CRC_POLYNOMIAL
    return value


@lru_cache(maxsize=64)
def _crc4_matrix(count: int) -> NDArray[np.int64]:
    """Return the contribution of each bit (including the CRC) to the remainder, shape (count, CRC_BITS)."""
    units = np.eye(count - CRC_BITS, dtype=np.uint8)
    columns = [_int_to_bits(_crc4(unit), CRC_BITS) for unit in units]
    return np.vstack([*columns, np.eye(CRC_BITS)]).astype(np.int64)


BLOCK_MAX = 255
"""Maximum bytes of a block over GF(256)."""
PARITY_DIVISOR = 7
PARITY_MIN = 4
PARITY_RESERVE = 2
"""Parity bytes reserved for error detection, not used for erasures."""


def segments_from_packet(packet: bytes, segment_bytes: int) -> list[Segment]:
    """Return the segments of a packet; raises `PacketError` if there are more than can be numbered."""
    for count in range(1, min((1 << INDEX_BITS) - 1, BLOCK_MAX // segment_bytes) + 1):
        size = count * segment_bytes
        capacity = size - parity_size(size) - 1
        if capacity >= len(packet):
            message = bytes([count]) + packet + bytes(capacity - len(packet))
            block = whiten(bytes(_codec(parity_size(size)).encode(message)))
            return [Segment(i, block[i * segment_bytes : (i + 1) * segment_bytes]) for i in range(count)]
    raise PacketError(f'packet has {len(packet)} bytes, too many for segments of {segment_bytes} bytes')


def packet_from_segments(content_by_index: Mapping[int, bytes]) -> Packet | None:
    """Return the packet of the received segments by index, or None if they are too few or inconsistent."""
    if 0 not in content_by_index:
        return None
    count, segment_bytes = segment_count(content_by_index[0]), len(content_by_index[0])
    size = count * segment_bytes
    parity = parity_size(size)
    missing = [i for i in range(count) if i not in content_by_index]
    if not parity < size <= BLOCK_MAX or len(missing) * segment_bytes + PARITY_RESERVE > parity:
        return None
    block = whiten(b''.join(content_by_index.get(i, bytes(segment_bytes)) for i in range(count)))
    erasures = [i * segment_bytes + k for i in missing for k in range(segment_bytes)]
    try:
        message = bytes(_codec(parity).decode(block, erase_pos=erasures)[0])
    except ReedSolomonError:
        return None
    length = packet_length(message[1:])
    return None if length is None or message[0] != count else read_packet(message[1 : 1 + length])


def segment_count(first: bytes) -> int:
    """Return the number of segments of a block, from the content of its first segment."""
    return whiten(first)[0]


def parity_size(size: int) -> int:
    """Return the number of parity bytes of a block."""
    return max(PARITY_MIN, size // PARITY_DIVISOR)


@lru_cache(maxsize=64)
def _codec(parity: int) -> RSCodec:
    return RSCodec(parity)
