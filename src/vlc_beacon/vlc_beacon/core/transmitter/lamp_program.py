"""Encodes packets for a lamp: waveform, firmware frame and code profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shirube_core.waveform import Waveform
from vlc_beacon.core.light_code.code_profile import (
    CodeProfile,
    manchester_profile,
    rs_fsk_profile,
    tone_profile,
    ufsook_profile,
)
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_waveform
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.transmitter.coded_frame import (
    constant_tone_frame,
    manchester_frame,
    rs_fsk_frame,
    ufsook_frame,
)
from vlc_beacon.core.transmitter.encoding_settings import (
    RS_FSK_NAME,
    TONE_NAME,
    UFSOOK_NAME,
    EncodingSettings,
)
from vlc_beacon.core.transmitter.lamp_frame import LampFrame


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
    """Encode a sequence of packets for a lamp.

    Args:
        packets: packets as bytes, at least one; ignored for a constant tone.
        settings: light code and camera.

    Raises:
        PacketError: a packet is too long for the code.
        LampFrameError: the firmware cannot play it.
        VlcBeaconError: invalid segment format.
    """
    contents, rate = list(packets), settings.frame_rate
    plays, ticks = settings.plays, settings.tick_rate
    if settings.code == TONE_NAME:
        return LampProgram(
            constant_tone_waveform(settings.tone),
            constant_tone_frame(settings.tone, ticks),
            tone_profile(settings.tone, settings.row_time),
        )
    if settings.code == UFSOOK_NAME:
        return LampProgram(ufsook_waveform(contents), ufsook_frame(contents, plays, ticks), ufsook_profile())
    if settings.code == RS_FSK_NAME:
        return LampProgram(
            rs_fsk_waveform(contents, rate),
            rs_fsk_frame(contents, rate, plays, ticks),
            rs_fsk_profile(rate, settings.row_time),
        )
    segments = SegmentFormat(settings.segment_bytes, frame_rate=rate)
    light = segments_waveform(
        [segment for c in contents for segment in segments_from_packet(c, segments.segment_bytes)], segments
    )
    profile = manchester_profile(segments, settings.row_time, settings.exposure_time)
    return LampProgram(light, manchester_frame(contents, segments, plays, ticks), profile)
