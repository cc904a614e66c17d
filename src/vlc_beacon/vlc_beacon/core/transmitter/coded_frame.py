"""Lamp frames of packets in each light code.

All functions take the measured clock of the lamp's timer: a ceramic resonator may be off by 0.5 %, more than decoders
tolerate, which is compensated here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vlc_beacon.core.light_code.manchester import PREAMBLE, SegmentFormat
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_code, symbol_tones
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.ufsook import EIGHTHS, FIRST_EIGHTH, HALF_LEVELS, UFSOOK
from vlc_beacon.core.transmitter.lamp_frame import TICK_RATE, LampFrame, Section, pulse_train_of_duration

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
    return LampFrame(
        _BLINK_PATTERN,
        UFSOOK.bits,
        pulse_trains,
        UFSOOK.preamble,
        _sections_from_packets(UFSOOK, packets),
        plays,
    )


def rs_fsk_frame(
    packets: Sequence[bytes], frame_rate: float, plays: int = 0, tick_rate: float = TICK_RATE
) -> LampFrame:
    """Return the frame of a sequence of packets in RS-FSK.

    Args:
        packets: encoded packets, at least one.
        frame_rate: frame rate of the slowest camera [1/s].
        plays: number of repetitions, see `LampFrame`.
        tick_rate: clock of the lamp's timer [1/s].
    """
    code = rs_fsk_code(frame_rate)
    pulse_trains = tuple(
        pulse_train_of_duration(0, round(2.0 * tone * code.duration), code.duration, tick_rate)
        for tone in symbol_tones(code)
    )
    return LampFrame(
        (ON, OFF), code.bits, pulse_trains, code.preamble, _sections_from_packets(code, packets), plays
    )


def manchester_frame(
    packets: Sequence[bytes], segment_format: SegmentFormat, plays: int = 0, tick_rate: float = TICK_RATE
) -> LampFrame:
    """Return the frame of a sequence of packets in Manchester segments."""
    chips = ((_ZERO_AT, 2), (_ONE_AT, 2), (_PREAMBLE_AT, len(PREAMBLE)))
    pulse_trains = tuple(
        pulse_train_of_duration(first, steps, steps * segment_format.chip_time, tick_rate)
        for first, steps in chips
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


def _sections_from_packets(code: SymbolCode, packets: Sequence[bytes]) -> list[Section]:
    data = [code.encode_symbols(packet)[len(code.preamble) :] for packet in packets]
    return [Section(symbols[None]) for symbols in data]
