"""Rows of a lamp, frame by frame, to packets or to a known tone (see `rs_fsk`)."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import pairwise

import numpy as np

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.row_tones import tone_likelihoods
from vlc_beacon.core.light_code.rs_fsk import MARKER, TONE_SPACING, rs_fsk_code, symbol_tones
from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

BEATS = 24
TONE_MARGIN = 8.0
"""Log likelihood by which a lamp's tone must be better than that of any other lamp."""
TONES_APART = 200.0
"""The tones of two lamps must differ by so much [Hz]."""
FOREIGN_HIGHEST = 11000.0
"""Exposures of usual cameras leave little of higher tones [Hz]."""


class RsFskDecoder:
    """Decodes one lamp.

    Args:
        frame_rate: that the lamp's waveform was made for [1/s].
    """

    def __init__(self, frame_rate: float) -> None:
        code = rs_fsk_code(frame_rate)
        self._tones = symbol_tones(code)
        self._receiver = SymbolReceiver(code, symbols=MARKER + 1, bins=1, candidates=BEATS)

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Take frames and return the packets that they complete; damaged frames are left out."""
        rows = rows.without_damage()
        tables = tone_likelihoods(rows, self._tones).astype(np.float32)[:, None]
        return self._receiver.add(rows.middles, tables)


class ToneDecoder:
    """Tells which of the known lamps plays a constant tone; to be used where lamps have no packets.

    A lamp that is not known plays some tone too. Foreign tones in the gaps between the known ones stand against them,
    so a lamp is named only where its tone explains the rows better than those. How much of the rows a tone explains
    would not do: few rows or noise leave a true tone less than many rows leave a foreign one.

    Args:
        tone_of_beacon: [Hz]; at least two lamps, `TONES_APART` or more apart.
    """

    def __init__(self, tone_of_beacon: Mapping[int, float]) -> None:
        self._beacons = tuple(tone_of_beacon)
        known = tuple(tone_of_beacon.values())
        self._tones = known + _foreign_tones(known)
        self._sums = np.zeros(len(self._tones))

    def add_frames(self, rows: LampRows) -> int | None:
        """Take frames and return the beacon that all since the last answer speak for, or None so far."""
        self._sums += tone_likelihoods(rows.without_damage(), self._tones).sum(axis=0)
        ordered = np.argsort(self._sums)
        if self._sums[ordered[-1]] - self._sums[ordered[-2]] < TONE_MARGIN:
            return None
        self._sums[:] = 0.0
        return self._beacons[ordered[-1]] if ordered[-1] < len(self._beacons) else None


def _foreign_tones(known: Collection[float]) -> tuple[float, ...]:
    """Return tones in the gaps between known ones, `TONE_SPACING` or more from each other and from those [Hz]."""
    edges = [0.0, *sorted(known), max(FOREIGN_HIGHEST, *known) + 2.0 * TONE_SPACING]
    gaps = [
        np.linspace(low, high, max(int((high - low) / TONE_SPACING), 1) + 1) for low, high in pairwise(edges)
    ]
    return tuple(np.concatenate([gap[1:-1] for gap in gaps]).tolist())
