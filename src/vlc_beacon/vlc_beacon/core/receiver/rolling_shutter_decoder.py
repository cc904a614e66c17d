"""Decodes one lamp under a rolling shutter: RS-FSK, Manchester segments if it is large, or a constant tone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vlc_beacon.core.lamp_image.row_profile import row_profile
from vlc_beacon.core.light_code.lamp_rows import LampRows, rows_from_frame
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.row_tones import ROWS_MIN
from vlc_beacon.core.light_code.rs_fsk_decoder import RsFskDecoder, ToneDecoder
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import LampView
from vlc_beacon.core.receiver.row_timing import RowTiming

FLICKER_MIN = 0.1
"""Minimum standard deviation of the normalized rows of a modulated lamp."""


class RollingShutterDecoder:
    """Decodes one lamp.

    Args:
        timing: timing of camera rows and lamps.
        tones: constant tones of the beacons [Hz], empty if the lamps send packets.
    """

    def __init__(self, timing: RowTiming, tones: Mapping[int, float]) -> None:
        self._timing = timing
        self._tone = ToneDecoder(tones) if tones else None
        self._fsk = RsFskDecoder(timing.lamp_frame_rate)
        self._manchester = ManchesterDecoder(timing.segments)

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes, see `LampDecoder`; a tone counts as an ID packet."""
        rows = self._rows(view)
        if rows is None:
            return []
        if self._tone is not None:
            beacon = self._tone.add_frames(rows)
            return [] if beacon is None else [ReceivedPacket(view.stamp, IdPacket(beacon))]
        timing = self._timing
        packets = self._fsk.add_frames(rows)
        if rows.brightness.shape[1] >= timing.segments.rows_min(timing.row_time, timing.exposure):
            packets += self._manchester.add_frames(rows)
        return packets

    def _rows(self, view: LampView) -> LampRows | None:
        """Return the lamp's rows, None if they are too few or not modulated."""
        sample, timing = view.sample, self._timing
        if not sample.is_lit:
            return None
        first, brightness = row_profile(view.image, sample.centre, sample.radius, view.background)
        if len(brightness) < ROWS_MIN or float(np.std(brightness)) < FLICKER_MIN:
            return None
        return rows_from_frame(view.stamp, first, brightness, timing.row_time, timing.exposure)
