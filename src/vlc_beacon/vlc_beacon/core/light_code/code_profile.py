"""Requirements and data rates of the light codes."""

import math
from dataclasses import dataclass

from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_from_packet
from vlc_beacon.core.light_code.rs_fsk import TONE_LOWEST, rs_fsk_code
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.ufsook import UFSOOK
from vlc_beacon.core.packet.command_packet import SHORT_BYTES
from vlc_beacon.core.packet.data_packet import DATA_OVERHEAD, ID_BYTES

_PACKET_BYTES = ID_BYTES, SHORT_BYTES, 100 + DATA_OVERHEAD
TONE_SECONDS = 1.0
"""Approximate identification time of a tone [s]; it depends on the tone separation."""
UFSOOK_ROWS_MIN = 6
"""Minimum lamp diameter at which its halves are resolved [px]."""


@dataclass(frozen=True)
class CodeProfile:
    """Requirements and message durations of a light code.

    Attributes:
        name: name of the code.
        rows_min: minimum number of image rows covered by a lamp.
        id_seconds: duration of an ID packet [s].
        command_seconds: duration of a short command packet with a value [s].
        seconds_per_100_bytes: duration of a packet with 100 bytes of data [s]. The latency is up to twice as long when
            reception starts within a packet; corrupted packets are repeated.
    """

    name: str
    rows_min: int
    id_seconds: float
    command_seconds: float
    seconds_per_100_bytes: float


def ufsook_profile() -> CodeProfile:
    """Return the profile of UFSOOK."""
    return _symbol_profile('ufsook', UFSOOK_ROWS_MIN, UFSOOK)


def rs_fsk_profile(frame_rate: float, row_time: float) -> CodeProfile:
    """Return the profile of RS-FSK for the slowest camera [1/s] and its line time [s]."""
    rows_min = math.ceil(1.0 / (TONE_LOWEST * row_time))
    return _symbol_profile('rs_fsk', rows_min, rs_fsk_code(frame_rate))


def tone_profile(tone: float, row_time: float) -> CodeProfile:
    """Return the profile of a constant tone [Hz], which carries only the lamp's identity."""
    return CodeProfile('tone', math.ceil(1.0 / (tone * row_time)), TONE_SECONDS, math.inf, math.inf)


def manchester_profile(segment_format: SegmentFormat, row_time: float, exposure: float) -> CodeProfile:
    """Return the profile of Manchester segments for a camera's line time and exposure [s]."""

    def seconds(packet_bytes: int) -> float:
        segments = segments_from_packet(bytes(packet_bytes), segment_format.segment_bytes)
        return len(segments) * segment_format.segment_seconds

    return CodeProfile('manchester', segment_format.rows_min(row_time, exposure), *map(seconds, _PACKET_BYTES))


def _symbol_profile(name: str, rows_min: int, code: SymbolCode) -> CodeProfile:
    return CodeProfile(name, rows_min, *map(code.packet_duration, _PACKET_BYTES))
