"""A packet as a Reed-Solomon block in slots, and back from the slots that were seen.

The block is ``number of slots | packet | zeros | parity``. A seventh of it is parity, four bytes at least: half as many
damaged bytes are mended, or as many that are known to be missing. Whitened it is cut into slots.
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
"""Bytes of a block: the code's symbols are those of GF(256)."""
PARITY_SHARE = 7
PARITY_MIN = 4
SPARE = 2
"""Parity bytes that are not spent on missing ones, so that a wrong byte does not go unnoticed."""


def slots_of_packet(packet: bytes, slot_bytes: int) -> list[Slot]:
    """Return the slots of a packet.

    Raises:
        PacketError: it needs more slots than can be numbered.
    """
    for count in range(1, min((1 << INDEX_BITS) - 1, BLOCK_MAX // slot_bytes) + 1):
        size = count * slot_bytes
        room = size - parity_of(size) - 1
        if room >= len(packet):
            message = bytes([count]) + packet + bytes(room - len(packet))
            block = whiten(bytes(_codec(parity_of(size)).encode(message)))
            return [Slot(i, block[i * slot_bytes : (i + 1) * slot_bytes]) for i in range(count)]
    raise PacketError(f'packet has {len(packet)} bytes, too many for slots of {slot_bytes} bytes')


def packet_of_slots(content_of_index: Mapping[int, bytes]) -> Packet | None:
    """Return the packet of the slots that were seen, or None where they are too few or contradict each other.

    Args:
        content_of_index: of each slot seen; slot 0 tells how many there are.
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
    """Return how many slots a block has, from the content of its first slot."""
    return whiten(first)[0]


def parity_of(size: int) -> int:
    """Return how many bytes of a block are parity."""
    return max(PARITY_MIN, size // PARITY_SHARE)


@lru_cache(maxsize=64)
def _codec(parity: int) -> RSCodec:
    return RSCodec(parity)
