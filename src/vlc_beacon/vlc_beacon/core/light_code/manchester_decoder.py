"""Decodes Manchester segments from the rows of a lamp (see `manchester`)."""

from __future__ import annotations

import numpy as np

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.manchester import INDEX_BITS, Segment, SegmentFormat, segment_from_bits
from vlc_beacon.core.light_code.reed_solomon_block import packet_from_segments, segment_count
from vlc_beacon.core.light_code.row_chips import demodulate_rows
from vlc_beacon.core.packet.packet_reader import Packet, ReceivedPacket

ROUNDS_KEPT = 2.5
"""Segments older than this number of rounds are dropped, because the lamp may send another packet."""


class ManchesterDecoder:
    """Decodes one lamp.

    Args:
        segment_format: segment format of the lamp.
    """

    def __init__(self, segment_format: SegmentFormat) -> None:
        self._format = segment_format
        self._seen: dict[int, tuple[float, bytes]] = {}

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; invalid frames are skipped."""
        rows = rows.drop_invalid_frames()
        bits, is_clear = demodulate_rows(rows, self._format)
        received = []
        for frame in np.flatnonzero(is_clear):
            segment = segment_from_bits(bits[frame])
            packet = None if segment is None else self._add_segment(segment, float(rows.stamps[frame]))
            if packet is not None:
                received.append(ReceivedPacket(float(rows.stamps[frame]), packet))
        return received

    def _add_segment(self, segment: Segment, stamp: float) -> Packet | None:
        """Return the packet completed by a segment, None if incomplete."""
        is_new = self._seen.get(segment.index, (0.0, b''))[1] != segment.content
        self._seen[segment.index] = stamp, segment.content
        self._drop_before(stamp - ROUNDS_KEPT * self._round_seconds())
        # A repeated segment cannot complete a packet.
        packet = (
            packet_from_segments({i: content for i, (_, content) in self._seen.items()}) if is_new else None
        )
        if packet is not None:
            self._seen.clear()
        return packet

    def _round_seconds(self) -> float:
        count = segment_count(self._seen[0][1]) if 0 in self._seen else 1 << INDEX_BITS
        return count * self._format.segment_seconds

    def _drop_before(self, stamp: float) -> None:
        for index in [i for i, (seen, _) in self._seen.items() if seen < stamp]:
            del self._seen[index]
