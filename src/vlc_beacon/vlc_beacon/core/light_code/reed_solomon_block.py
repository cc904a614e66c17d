"""Encodes a packet as a Reed-Solomon block in segments, and decodes it from the received segments.

The block is ``number of segments | packet | zeros | parity``. A seventh of it is parity, at least four bytes: it
corrects half as many errors or as many erasures. The whitened block is split into segments.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from reedsolo import ReedSolomonError, RSCodec

from vlc_beacon.core.light_code.manchester import INDEX_BITS, Slot
from vlc_beacon.core.light_code.whitening import whiten
from vlc_beacon.core.packet.packet_error import PacketError
from vlc_beacon.core.packet.packet_reader import Packet, packet_length, read_packet

BLOCK_MAX = 255
"""Maximum bytes of a block over GF(256)."""
PARITY_SHARE = 7
PARITY_MIN = 4
SPARE = 2
"""Parity bytes reserved for error detection, not used for erasures."""


def slots_of_packet(packet: bytes, slot_bytes: int) -> list[Slot]:
    """Return the segments of a packet.

    Raises:
        PacketError: it needs more segments than can be numbered.
    """
    for count in range(1, min((1 << INDEX_BITS) - 1, BLOCK_MAX // slot_bytes) + 1):
        size = count * slot_bytes
        room = size - parity_of(size) - 1
        if room >= len(packet):
            message = bytes([count]) + packet + bytes(room - len(packet))
            block = whiten(bytes(_codec(parity_of(size)).encode(message)))
            return [Slot(i, block[i * slot_bytes : (i + 1) * slot_bytes]) for i in range(count)]
    raise PacketError(f'packet has {len(packet)} bytes, too many for segments of {slot_bytes} bytes')


def packet_of_slots(content_of_index: Mapping[int, bytes]) -> Packet | None:
    """Return the packet of the received segments, or None if they are too few or inconsistent.

    Args:
        content_of_index: content of each received segment; segment 0 holds their number.
    """
    if 0 not in content_of_index:
        return None
    count, slot_bytes = slot_count(content_of_index[0]), len(content_of_index[0])
    size = count * slot_bytes
    parity = parity_of(size)
    missing = [i for i in range(count) if i not in content_of_index]
    if not parity < size <= BLOCK_MAX or len(missing) * slot_bytes + SPARE > parity:
        return None
    block = whiten(b''.join(content_of_index.get(i, bytes(slot_bytes)) for i in range(count)))
    erasures = [i * slot_bytes + k for i in missing for k in range(slot_bytes)]
    try:
        message = bytes(_codec(parity).decode(block, erase_pos=erasures)[0])
    except ReedSolomonError:
        return None
    length = packet_length(message[1:])
    return None if length is None or message[0] != count else read_packet(message[1 : 1 + length])


def slot_count(first: bytes) -> int:
    """Return the number of segments of a block, from the content of its first segment."""
    return whiten(first)[0]


def parity_of(size: int) -> int:
    """Return the number of parity bytes of a block."""
    return max(PARITY_MIN, size // PARITY_SHARE)


@lru_cache(maxsize=64)
def _codec(parity: int) -> RSCodec:
    return RSCodec(parity)
