"""Decodes RS-FSK packets or a constant tone from the rows of a lamp (see `rs_fsk`)."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import pairwise

import numpy as np

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.row_tones import tone_log_likelihoods
from vlc_beacon.core.light_code.rs_fsk import PREAMBLE_SYMBOL, TONE_SPACING, rs_fsk_code, symbol_tones
from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

TIMING_PHASES = 24
TONE_MARGIN = 8.0
"""Minimum log-likelihood ratio between the best tone and the runner-up."""
TONE_SEPARATION_MIN = 200.0
"""Minimum separation between the tones of two lamps [Hz]."""
UNKNOWN_TONE_MAX = 11000.0
"""Highest unknown tone considered [Hz]; typical exposures suppress higher ones."""


class RsFskDecoder:
    """Decodes one lamp.

    Args:
        frame_rate: frame rate the lamp was encoded for [1/s].
    """

    def __init__(self, frame_rate: float) -> None:
        code = rs_fsk_code(frame_rate)
        self._tones = symbol_tones(code)
        self._receiver = SymbolReceiver(code, symbols=PREAMBLE_SYMBOL + 1, bins=1, candidates=TIMING_PHASES)

    def add_frames(self, rows: LampRows) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete; invalid frames are skipped."""
        rows = rows.drop_invalid_frames()
        tables = tone_log_likelihoods(rows, self._tones).astype(np.float32)[:, None]
        return self._receiver.add(rows.centre_times, tables)


class ToneDecoder:
    """Identifies which known lamp sends a constant tone, for lamps without packets.

    An unknown lamp may send any tone. Unknown tones in the gaps between the known ones are alternative hypotheses, so a
    lamp is identified only if its tone is more likely than those. A threshold on the residual would not work: it
    depends on the number of rows and on the noise.

    Args:
        tone_by_beacon: tone of each beacon by ID [Hz]; at least two, separated by `TONE_SEPARATION_MIN` or more.
    """

    def __init__(self, tone_by_beacon: Mapping[int, float]) -> None:
        self._beacons = tuple(tone_by_beacon)
        known = tuple(tone_by_beacon.values())
        self._tones = known + _unknown_tones(known)
        self._sums = np.zeros(len(self._tones))

    def add_frames(self, rows: LampRows) -> int | None:
        """Add frames and return the identified beacon, or None while it is ambiguous."""
        self._sums += tone_log_likelihoods(rows.drop_invalid_frames(), self._tones).sum(axis=0)
        ordered = np.argsort(self._sums)
        if self._sums[ordered[-1]] - self._sums[ordered[-2]] < TONE_MARGIN:
            return None
        self._sums[:] = 0.0
        return self._beacons[ordered[-1]] if ordered[-1] < len(self._beacons) else None


def _unknown_tones(known: Collection[float]) -> tuple[float, ...]:
    """Return unknown tones in the gaps between known ones, at least `TONE_SPACING` from any other tone [Hz]."""
    edges = [0.0, *sorted(known), max(UNKNOWN_TONE_MAX, *known) + 2.0 * TONE_SPACING]
    gaps = [
        np.linspace(low, high, max(int((high - low) / TONE_SPACING), 1) + 1) for low, high in pairwise(edges)
    ]
    return tuple(np.concatenate([gap[1:-1] for gap in gaps]).tolist())
