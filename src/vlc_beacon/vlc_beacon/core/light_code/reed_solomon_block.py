"""Encodes a packet as a Reed-Solomon block in segments, and decodes it from the received segments.

The block is ``number of segments | packet | zeros | parity``. A seventh of it is parity, at least four bytes: it
corrects half as many errors or as many erasures. The whitened block is split into segments.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from reedsolo import ReedSolomonError, RSCodec

from vlc_beacon.core.light_code.manchester import INDEX_BITS, Segment
from vlc_beacon.core.light_code.whitening import whiten
from vlc_beacon.core.packet.packet_error import PacketError
from vlc_beacon.core.packet.packet_reader import Packet, packet_length, read_packet

BLOCK_MAX = 255
"""Maximum bytes of a block over GF(256)."""
PARITY_DIVISOR = 7
PARITY_MIN = 4
PARITY_RESERVE = 2
"""Parity bytes reserved for error detection, not used for erasures."""


def segments_from_packet(packet: bytes, segment_bytes: int) -> list[Segment]:
    """Return the segments of a packet.

    Raises:
        PacketError: it needs more segments than can be numbered.
    """
    for count in range(1, min((1 << INDEX_BITS) - 1, BLOCK_MAX // segment_bytes) + 1):
        size = count * segment_bytes
        capacity = size - parity_size(size) - 1
        if capacity >= len(packet):
            message = bytes([count]) + packet + bytes(capacity - len(packet))
            block = whiten(bytes(_codec(parity_size(size)).encode(message)))
            return [Segment(i, block[i * segment_bytes : (i + 1) * segment_bytes]) for i in range(count)]
    raise PacketError(f'packet has {len(packet)} bytes, too many for segments of {segment_bytes} bytes')


def packet_from_segments(content_by_index: Mapping[int, bytes]) -> Packet | None:
    """Return the packet of the received segments, or None if they are too few or inconsistent.

    Args:
        content_by_index: content of each received segment; segment 0 holds their number.
    """
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
