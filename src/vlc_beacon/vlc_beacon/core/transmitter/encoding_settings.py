"""Settings of the encoder: light code and camera."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting
from vlc_beacon.core.light_code.manchester import SEGMENT_BYTES_MAX
from vlc_beacon.core.transmitter.lamp_frame import PLAYS_MAX, TICK_RATE

UFSOOK_NAME, RS_FSK_NAME, MANCHESTER_NAME, TONE_NAME = 'ufsook', 'rs_fsk', 'manchester', 'tone'


@dataclass(frozen=True)
class EncodingSettings:
    """Encoding of a lamp's light."""

    code: str = setting(
        UFSOOK_NAME,
        'light code: ufsook for global shutters; rs_fsk, manchester or a constant tone for rolling shutters',
        choices=(UFSOOK_NAME, RS_FSK_NAME, MANCHESTER_NAME, TONE_NAME),
    )
    frame_rate: float = setting(
        30.0,
        'frame rate of the slowest camera for rs_fsk or manchester; ufsook is for 60',
        unit='1/s',
        minimum=5.0,
        maximum=240.0,
    )
    row_time: float = setting(
        18.9e-6,
        'line time of the rolling shutter, to compute the rows a lamp must cover',
        unit='s',
        minimum=1e-6,
        maximum=1e-3,
    )
    exposure_time: float = setting(
        6e-5,
        'exposure of the rows, to compute the rows a lamp must cover',
        unit='s',
        minimum=1e-6,
        maximum=0.01,
    )
    segment_bytes: int = setting(
        1,
        'bytes per Manchester segment: more need larger lamps and reduce overhead; set the same in the receiver',
        minimum=1,
        maximum=SEGMENT_BYTES_MAX,
        former_name='slot_bytes',
    )
    tone: float = setting(
        4000.0,
        'frequency of a constant tone (code tone), as in the beacons file',
        unit='Hz',
        minimum=1000.0,
        maximum=8000.0,
    )
    tick_rate: float = setting(
        TICK_RATE, "measured clock of the lamp's timer", unit='1/s', minimum=1e6, maximum=1e8
    )
    plays: int = setting(
        0,
        'repetitions of a temporary frame before the stored frame resumes; 0 for no limit',
        minimum=0,
        maximum=PLAYS_MAX,
    )
