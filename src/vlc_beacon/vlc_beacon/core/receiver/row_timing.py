"""When the rows of a rolling shutter see the light, and how long the dark stripes are that lamps show in it."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from vlc_beacon.core.light_code.manchester import SlotFormat
from vlc_beacon.core.light_code.rs_fsk import TONE_LOWEST
from vlc_beacon.core.receiver.settings import ReceiverSettings

_DARK_CHIPS = 4
"""A slot's bit 01 after its preamble 111000 is dark for so long."""


@dataclass(frozen=True)
class RowTiming:
    """Timing of rows and lamps.

    Attributes:
        row_time: between the beginnings of two rows [s].
        exposure: of a row [s].
        lamp_frame_rate: that the lamps were made for [1/s].
        stripe_rows: longest dark stripe in a lamp [px].
        slots: of Manchester.
    """

    row_time: float
    exposure: float
    lamp_frame_rate: float
    stripe_rows: float
    slots: SlotFormat


def row_timing(settings: ReceiverSettings, tones: Collection[float]) -> RowTiming:
    """Return the timing that settings ask for; stripes are those of the codes unless the settings tell them.

    Args:
        settings: of the receiver.
        tones: of the beacons [Hz], empty where they play packets.
    """
    row_time = settings.row_time
    dark = 0.5 / min(tones, default=TONE_LOWEST)
    slots = SlotFormat(settings.slot_bytes, frame_rate=settings.lamp_frame_rate)
    if settings.lamps.diameter_max >= slots.rows_min(row_time, settings.exposure_time):
        dark = max(dark, _DARK_CHIPS * slots.chip_time)
    # A row that is dark in part only looks dark too.
    stripe_rows = settings.lamps.stripe_rows or math.ceil(dark / row_time) + 1
    return RowTiming(row_time, settings.exposure_time, settings.lamp_frame_rate, float(stripe_rows), slots)
