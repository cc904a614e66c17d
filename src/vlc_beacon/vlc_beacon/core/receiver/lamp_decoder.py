"""Decoders of one tracked lamp: UFSOOK under a global shutter; RS-FSK, Manchester or a tone under a rolling shutter."""

import math
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.lamp_image.row_profile import LampRows, row_profile, rows_from_frame
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import ROWS_MIN, TONE_LOWEST, RsFskDecoder, ToneDecoder
from vlc_beacon.core.light_code.ufsook import UfsookDecoder
from vlc_beacon.core.packet.data_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.settings import ReceiverSettings

WINDOW_FRAMES, FRAMES_MIN = 120, 12
"""Most and fewest frames of the gain control."""
TAIL_FRACTION = 0.05
"""Quantile of the dark level, and 1 minus that of the bright level: small, because with almost equal clocks one of the
two may be sampled rarely."""
CONTRAST_MIN = 0.1
"""A lamp whose modulation is below this fraction of full light carries no code."""
CONFIRMATION_PACKETS = 2
"""Number of packets that determine the order of the halves."""
DARK_CHIPS = 4
"""Longest dark run of a Manchester segment: bit 01 after the preamble 111000 [chips]."""
FLICKER_MIN = 0.1
"""Minimum standard deviation of the normalized rows of a modulated lamp."""


@dataclass(frozen=True)
class LampView:
    """A lamp in one frame.

    Attributes:
        stamp: stamp of the frame [s].
        image: grey image, shape (h, w).
        sample: the tracked lamp.
        background: brightness of the background [grey levels]; NaN while the lamp is dark.
    """

    stamp: float
    image: NDArray[np.uint8]
    sample: LampSample
    background: float


class LampDecoder(Protocol):
    """Decodes one lamp, frame by frame."""

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes; a lamp without modulation is not processed."""


class GainControl:
    """Gain control: dark and full brightness of a lamp's halves from its recent frames.

    Both halves share one scale: with almost equal clocks one half may be sampled at its edges, neither dark nor full,
    for seconds, but the other half is dark or full at that time.
    """

    def __init__(self) -> None:
        self._history: deque[NDArray[np.float64]] = deque(maxlen=WINDOW_FRAMES)

    def normalize(self, grey: ArrayLike) -> NDArray[np.float64]:
        """Add a frame of any unit and return its brightness, shape (2,), from 0 to 1; NaN while unknown."""
        now, unknown = np.asarray(grey, float), np.full(2, np.nan)
        if not np.isfinite(now).all():
            return unknown
        self._history.append(now)
        if len(self._history) < FRAMES_MIN:
            return unknown
        values = np.concatenate(self._history)
        tail = int(TAIL_FRACTION * len(values))
        ordered = np.partition(values, (tail, len(values) - 1 - tail))
        dark, bright = ordered[tail], ordered[len(values) - 1 - tail]
        return unknown if bright - dark <= CONTRAST_MIN * abs(bright) else (now - dark) / (bright - dark)


class GlobalShutterDecoder:
    """Decodes one lamp under a global shutter: UFSOOK on the brightness of its halves.

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
            found = decoder.add_frames(np.array([view.stamp]), brightness[None, ::order], self._exposure)
            self._packet_counts[order] += len(found)
            packets += found
            if self._packet_counts[order] >= CONFIRMATION_PACKETS:
                self._decoders = {order: decoder}
        return packets


def band_rows(settings: ReceiverSettings, tones: Collection[float]) -> float:
    """Return the maximum height of a dark band in a lamp [px], which follows from the light codes unless it is set.

    Args:
        settings: receiver settings.
        tones: constant tones of the beacons [Hz], empty if they send packets.
    """
    dark, segments = 0.5 / min(tones, default=TONE_LOWEST), settings.segment_format
    if settings.lamps.diameter_max >= segments.rows_min(settings.row_time, settings.exposure_time):
        dark = max(dark, DARK_CHIPS * segments.chip_time)
    # A partly dark row appears dark too.
    return settings.lamps.stripe_rows or float(math.ceil(dark / settings.row_time) + 1)


class RollingShutterDecoder:
    """Decodes one lamp under a rolling shutter: RS-FSK, Manchester segments if it is large, or a constant tone.

    Args:
        settings: receiver settings with row timing and segments.
        tones: constant tones of the beacons [Hz], empty if the lamps send packets.
    """

    def __init__(self, settings: ReceiverSettings, tones: Mapping[int, float]) -> None:
        self._row_time, self._exposure = settings.row_time, settings.exposure_time
        self._tone = ToneDecoder(tones) if tones else None
        self._fsk = RsFskDecoder(settings.lamp_frame_rate)
        self._manchester = ManchesterDecoder(settings.segment_format)
        self._manchester_rows = settings.segment_format.rows_min(self._row_time, self._exposure)

    def read(self, view: LampView) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes, see `LampDecoder`; a tone counts as an ID packet."""
        rows = self._rows(view)
        if rows is None:
            return []
        if self._tone is not None:
            beacon = self._tone.add_frames(rows)
            return [] if beacon is None else [ReceivedPacket(view.stamp, IdPacket(beacon))]
        packets = self._fsk.add_frames(rows)
        if rows.brightness.shape[1] >= self._manchester_rows:
            packets += self._manchester.add_frames(rows)
        return packets

    def _rows(self, view: LampView) -> LampRows | None:
        """Return the lamp's rows, None if they are too few or not modulated."""
        if not view.sample.is_lit:
            return None
        first, brightness = row_profile(view.image, view.sample.centre, view.sample.radius, view.background)
        if len(brightness) < ROWS_MIN or float(np.std(brightness)) < FLICKER_MIN:
            return None
        return rows_from_frame(view.stamp, first, brightness, self._row_time, self._exposure)
