"""Encodes packets for a lamp: waveform, firmware frame and code profile.

Frames are made for the measured clock of the lamp's timer: a ceramic resonator may be off by 0.5 %, more than decoders
tolerate.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shirube_core.settings import setting
from shirube_core.waveform import Waveform
from vlc_beacon.core.light_code.code_profile import (
    CodeProfile,
    manchester_profile,
    rs_fsk_profile,
    tone_profile,
    ufsook_profile,
)
from vlc_beacon.core.light_code.manchester import (
    PREAMBLE,
    SEGMENT_BYTES_MAX,
    SegmentFormat,
    segments_from_packet,
    segments_waveform,
)
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform, rs_fsk_code, rs_fsk_waveform, symbol_tones
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.ufsook import EIGHTHS, FIRST_EIGHTH, HALF_LEVELS, UFSOOK, ufsook_waveform
from vlc_beacon.core.transmitter.lamp_frame import (
    PLAYS_MAX,
    TICK_RATE,
    LampFrame,
    PulseTrain,
    Section,
    pulse_train_of_duration,
)

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
        30.0, 'frame rate of the slowest camera for rs_fsk or manchester; ufsook is for 60', '1/s', (5.0, 240.0)
    )
    row_time: float = setting(
        18.9e-6, 'line time of the rolling shutter, to compute the rows a lamp must cover', 's', (1e-6, 1e-3)
    )
    exposure_time: float = setting(
        6e-5, 'exposure of the rows, to compute the rows a lamp must cover', 's', (1e-6, 0.01)
    )
    segment_bytes: int = setting(
        1,
        'bytes per Manchester segment: more need larger lamps and reduce overhead; set the same in the receiver',
        limits=(1, SEGMENT_BYTES_MAX),
        former_name='slot_bytes',
    )
    tone: float = setting(
        4000.0, 'frequency of a constant tone (code tone), as in the beacons file', 'Hz', (1000.0, 8000.0)
    )
    tick_rate: float = setting(TICK_RATE, "measured clock of the lamp's timer", '1/s', (1e6, 1e8))
    plays: int = setting(
        0, 'repetitions of a temporary frame before the stored frame resumes; 0 for no limit', limits=(0, PLAYS_MAX)
    )


OFF, ON_A, ON_B, ON = range(4)
"""States of the lamp: none, one or both halves on."""
_BLINK_PATTERN = tuple((HALF_LEVELS @ (ON_A, ON_B)).astype(int).tolist())
"""States of the lamp in each eighth of a cycle of UFSOOK."""
_CHIP_PATTERN = tuple(ON if chip else OFF for chip in PREAMBLE)
_ONE_AT, _ZERO_AT, _PREAMBLE_AT = 2, 5, 0
"""Start indices of 10, 01 and the preamble in the pattern of the preamble's chips."""


def ufsook_frame(packets: Sequence[bytes], plays: int = 0, tick_rate: float = TICK_RATE) -> LampFrame:
    """Return the frame of a sequence of packets in UFSOOK."""
    pulse_trains = tuple(
        pulse_train_of_duration(first, eighths, UFSOOK.duration, tick_rate)
        for first, eighths in zip(FIRST_EIGHTH, EIGHTHS, strict=True)
    )
    return _symbol_frame(_BLINK_PATTERN, UFSOOK, pulse_trains, packets, plays)


def rs_fsk_frame(
    packets: Sequence[bytes], frame_rate: float, plays: int = 0, tick_rate: float = TICK_RATE
) -> LampFrame:
    """Return the frame of a sequence of packets in RS-FSK for the slowest camera [1/s]."""
    code = rs_fsk_code(frame_rate)
    pulse_trains = tuple(
        pulse_train_of_duration(0, round(2.0 * tone * code.duration), code.duration, tick_rate)
        for tone in symbol_tones(code)
    )
    return _symbol_frame((ON, OFF), code, pulse_trains, packets, plays)


def manchester_frame(
    packets: Sequence[bytes], segment_format: SegmentFormat, plays: int = 0, tick_rate: float = TICK_RATE
) -> LampFrame:
    """Return the frame of a sequence of packets in Manchester segments."""
    chips = ((_ZERO_AT, 2), (_ONE_AT, 2), (_PREAMBLE_AT, len(PREAMBLE)))
    pulse_trains = tuple(
        pulse_train_of_duration(first, steps, steps * segment_format.chip_time, tick_rate) for first, steps in chips
    )
    sections = []
    for packet in packets:
        segments = segments_from_packet(packet, segment_format.segment_bytes)
        bits = np.array([segment.chips()[len(PREAMBLE) :: 2] for segment in segments], np.int64)
        sections.append(Section(bits, segment_format.repeats))
    return LampFrame(_CHIP_PATTERN, 1, pulse_trains, (2,), sections, plays)


def constant_tone_frame(tone: float, tick_rate: float = TICK_RATE) -> LampFrame:
    """Return the frame of a lamp that is identified by a constant tone [Hz]."""
    cycle = pulse_train_of_duration(0, 2, 1.0 / tone, tick_rate)
    return LampFrame((ON, OFF), 1, (cycle, cycle), (), [Section(np.zeros((1, 1), np.int64))])


def _symbol_frame(
    pattern: tuple[int, ...],
    code: SymbolCode,
    pulse_trains: tuple[PulseTrain, ...],
    packets: Sequence[bytes],
    plays: int,
) -> LampFrame:
    sections = [Section(code.encode_symbols(packet)[None, len(code.preamble) :]) for packet in packets]
    return LampFrame(pattern, code.bits, pulse_trains, code.preamble, sections, plays)


@dataclass(frozen=True)
class LampProgram:
    """The periodic output of a lamp.

    Attributes:
        waveform: waveform, with two parts for UFSOOK and one for the other codes.
        frame: frame for the firmware.
        profile: requirements and durations of the code.
    """

    waveform: Waveform
    frame: LampFrame
    profile: CodeProfile


def encode_packets(packets: Sequence[bytes], settings: EncodingSettings) -> LampProgram:
    """Encode a sequence of packets, at least one and ignored for a constant tone, for a lamp.

    Raises:
        PacketError: a packet is too long for the code.
        LampFrameError: the firmware cannot play it.
        VlcBeaconError: invalid segment format.
    """
    contents, rate, row_time = list(packets), settings.frame_rate, settings.row_time
    tone, plays, ticks = settings.tone, settings.plays, settings.tick_rate
    if settings.code == TONE_NAME:
        frame = constant_tone_frame(tone, ticks)
        return LampProgram(constant_tone_waveform(tone), frame, tone_profile(tone, row_time))
    if settings.code == UFSOOK_NAME:
        return LampProgram(ufsook_waveform(contents), ufsook_frame(contents, plays, ticks), ufsook_profile())
    if settings.code == RS_FSK_NAME:
        frame = rs_fsk_frame(contents, rate, plays, ticks)
        return LampProgram(rs_fsk_waveform(contents, rate), frame, rs_fsk_profile(rate, row_time))
    segments = SegmentFormat(settings.segment_bytes, frame_rate=rate)
    light = segments_waveform(
        [segment for c in contents for segment in segments_from_packet(c, segments.segment_bytes)], segments
    )
    profile = manchester_profile(segments, row_time, settings.exposure_time)
    return LampProgram(light, manchester_frame(contents, segments, plays, ticks), profile)
