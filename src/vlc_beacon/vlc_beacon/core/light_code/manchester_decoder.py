"""Decodes Manchester segments from the rows of a lamp (see `manchester`)."""

from __future__ import annotations

import numpy as np

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.manchester import INDEX_BITS, Slot, SlotFormat, slot_of_bits
from vlc_beacon.core.light_code.reed_solomon_block import packet_of_slots, slot_count
from vlc_beacon.core.light_code.row_chips import bits_of_rows
from vlc_beacon.core.packet.packet_reader import Packet, ReceivedPacket

ROUNDS = 2.5
"""Segments older than this number of rounds are dropped, because the lamp may send another packet."""


class ManchesterDecoder:
    """Decodes one lamp.

    Args:
        slot_format: segment format of the lamp.
    """

    def __init__(self, slot_format: SlotFormat) -> None:
        self._format = slot_format
        self._seen: dict[int, tuple[float, bytes]] = {}

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; invalid frames are skipped."""
        rows = rows.without_damage()
        bits, is_clear = bits_of_rows(rows, self._format)
        received = []
        for frame in np.flatnonzero(is_clear):
            slot = slot_of_bits(bits[frame])
            packet = None if slot is None else self._take(slot, float(rows.stamps[frame]))
            if packet is not None:
                received.append(ReceivedPacket(float(rows.stamps[frame]), packet))
        return received

    def _take(self, slot: Slot, stamp: float) -> Packet | None:
        """Return the packet completed by a segment, None if incomplete."""
        is_new = self._seen.get(slot.index, (0.0, b''))[1] != slot.content
        self._seen[slot.index] = stamp, slot.content
        self._forget_before(stamp - ROUNDS * self._round_seconds())
        # A repeated segment cannot complete a packet.
        packet = packet_of_slots({i: content for i, (_, content) in self._seen.items()}) if is_new else None
        if packet is not None:
            self._seen.clear()
        return packet

    def _round_seconds(self) -> float:
        count = slot_count(self._seen[0][1]) if 0 in self._seen else 1 << INDEX_BITS
        return count * self._format.slot_seconds

    def _forget_before(self, stamp: float) -> None:
        for index in [i for i, (seen, _) in self._seen.items() if seen < stamp]:
            del self._seen[index]
