"""Timing of rolling shutter rows, and the maximum height of dark bands."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from vlc_beacon.core.light_code.manchester import SegmentFormat
from vlc_beacon.core.light_code.rs_fsk import TONE_LOWEST
from vlc_beacon.core.receiver.settings import ReceiverSettings

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
