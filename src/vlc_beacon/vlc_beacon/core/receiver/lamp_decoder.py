"""Decoders of one tracked lamp: UFSOOK under a global shutter; RS-FSK, Manchester or a tone under a rolling shutter."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.lamp_image.row_profile import LampRows, row_profile, rows_from_frame
from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import ROWS_MIN, TONE_LOWEST, RsFskDecoder, ToneDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.settings import ReceiverSettings


@dataclass(frozen=True)
class LampView:
    """A lamp in one frame.

    Attributes:
        stamp: stamp of the frame [s].
        image: grey image, shape (h, w).
        sample: the tracked lamp.
        background: brightness of the background [grey levels]; the last known value while the lamp is dark.
    """

    stamp: float
    image: NDArray[np.uint8]
    sample: LampSample
    background: float


class LampDecoder(Protocol):
    """Decodes one lamp, frame by frame."""

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes.

        A lamp without modulation carries no code and is not processed.
        """


WINDOW_FRAMES = 120
FRAMES_MIN = 12
TAIL_FRACTION = 0.05
"""Quantile of the dark level, and 1 minus that of the bright level: small, because with almost equal clocks one of the
two may be sampled rarely."""
CONTRAST_MIN = 0.1
"""A lamp whose modulation is below this fraction of full light carries no code."""


class GainControl:
    """Normalizes the grey values of one lamp's halves for `UfsookDecoder`."""

    def __init__(self) -> None:
        self._history: deque[NDArray[np.float64]] = deque(maxlen=WINDOW_FRAMES)

    def normalize(self, grey: ArrayLike) -> NDArray[np.float64]:
        """Add a frame and return its brightness relative to full light, shape (2,), NaN while the gain is unknown.

        Args:
            grey: mean grey value of each half, shape (2,), any unit; NaN if not visible.
        """
        now = np.asarray(grey, float)
        if not np.isfinite(now).all():
            return np.full(2, np.nan)
        self._history.append(now)
        if len(self._history) < FRAMES_MIN:
            return np.full(2, np.nan)
        values = np.concatenate(self._history)
        tail = int(TAIL_FRACTION * len(values))
        ordered = np.partition(values, (tail, len(values) - 1 - tail))
        dark, bright = ordered[tail], ordered[len(values) - 1 - tail]
        if bright - dark <= CONTRAST_MIN * abs(bright):
            return np.full(2, np.nan)
        return (now - dark) / (bright - dark)


CONFIRMATION_PACKETS = 2
"""Number of packets that determine the order of the halves."""


class GlobalShutterDecoder:
    """Decodes one lamp.

    The order of the halves is unknown, and with the halves swapped no packets are decoded: both orders are tried until
    one of them has yielded packets.

    Args:
        exposure: exposure of the frames [s].
    """

    def __init__(self, exposure: float) -> None:
        self._exposure = exposure
        self._gain = GainControl()
        self._decoders = {1: UfsookDecoder(), -1: UfsookDecoder()}
        self._packet_counts = {1: 0, -1: 0}

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes, see `LampDecoder`."""
        brightness = self._gain.normalize(view.sample.half_brightness)
        if not np.isfinite(brightness).all():
            return []
        packets = []
        for order, decoder in list(self._decoders.items()):
            found = decoder.add_frame(view.stamp, brightness[::order], self._exposure)
            self._packet_counts[order] += len(found)
            packets += found
            if self._packet_counts[order] >= CONFIRMATION_PACKETS:
                self._decoders = {order: decoder}
        return packets


_DARK_CHIPS = 4
"""Longest dark run of a segment: bit 01 after the preamble 111000 [chips]."""


@dataclass(frozen=True)
class RowTiming:
    """Timing of rows and lamps.

    Attributes:
        row_time: line time between the starts of two rows [s].
        exposure: exposure of a row [s].
        lamp_frame_rate: frame rate the lamps were encoded for [1/s].
        stripe_rows: maximum height of a dark band in a lamp [px].
        segments: Manchester segment format.
    """

    row_time: float
    exposure: float
    lamp_frame_rate: float
    stripe_rows: float
    segments: SegmentFormat


def row_timing(settings: ReceiverSettings, tones: Collection[float]) -> RowTiming:
    """Return the timing of the settings; the band height follows from the light codes unless it is set.

    Args:
        settings: receiver settings.
        tones: constant tones of the beacons [Hz], empty if they send packets.
    """
    row_time = settings.row_time
    dark = 0.5 / min(tones, default=TONE_LOWEST)
    segments = SegmentFormat(settings.segment_bytes, frame_rate=settings.lamp_frame_rate)
    if settings.lamps.diameter_max >= segments.rows_min(row_time, settings.exposure_time):
        dark = max(dark, _DARK_CHIPS * segments.chip_time)
    # A partly dark row appears dark too.
    stripe_rows = settings.lamps.stripe_rows or math.ceil(dark / row_time) + 1
    return RowTiming(row_time, settings.exposure_time, settings.lamp_frame_rate, float(stripe_rows), segments)


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
