"""In which light code a lamp speaks, and to which camera."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting
from vlc_beacon.core.light_code.manchester import SLOT_BYTES_MAX
from vlc_beacon.core.transmitter.lamp_frame import PLAYS_MAX, TICK_RATE

UFSOOK_NAME, RS_FSK_NAME, MANCHESTER_NAME, TONE_NAME = 'ufsook', 'rs_fsk', 'manchester', 'tone'


@dataclass(frozen=True)
class EncodingSettings:
    """How a lamp's light is encoded."""

    code: str = setting(
        UFSOOK_NAME,
        'light code: ufsook for global shutters, rs_fsk, manchester and a constant tone for rolling ones',
        choices=(UFSOOK_NAME, RS_FSK_NAME, MANCHESTER_NAME, TONE_NAME),
    )
    frame_rate: float = setting(
        30.0,
        'of the slowest camera that shall read rs_fsk or manchester; ufsook is for 60',
        unit='1/s',
        minimum=5.0,
        maximum=240.0,
    )
    row_time: float = setting(
        18.9e-6,
        'of the rolling shutter, to tell how many rows a lamp must cover',
        unit='s',
        minimum=1e-6,
        maximum=1e-3,
    )
    exposure_time: float = setting(
        6e-5, 'of its rows, to tell the same', unit='s', minimum=1e-6, maximum=0.01
    )
    slot_bytes: int = setting(
        1,
        'bytes in a slot of manchester: more need larger lamps and waste less time; the receiver must know it',
        minimum=1,
        maximum=SLOT_BYTES_MAX,
    )
    tone: float = setting(
        4000.0,
        'of a lamp that plays nothing else (code tone); it stands as frequency in the beacons file',
        unit='Hz',
        minimum=1000.0,
        maximum=8000.0,
    )
    tick_rate: float = setting(
        TICK_RATE, "measured clock of the lamp's timer", unit='1/s', minimum=1e6, maximum=1e8
    )
    plays: int = setting(
        0,
        'after how many plays a frame that is not kept gives way to the one that is; 0 for never',
        minimum=0,
        maximum=PLAYS_MAX,
    )
