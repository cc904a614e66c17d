import numpy as np
import pytest
from light_channel import seen_by_rolling_shutter

from vlc_beacon.core.light_code.code_profile import (
    CodeProfile,
    manchester_profile,
    rs_fsk_profile,
    ufsook_profile,
)
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_from_packet, segments_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder
from vlc_beacon.core.light_code.rs_fsk import RsFskDecoder, rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket

PACKETS = (IdPacket(5), CommandPacket(Command(3, 1, 0.0, 9), b'abcd'), DataPacket(bytes(range(100))))


def stated(profile: CodeProfile) -> list[float]:
    return [profile.id_seconds, profile.command_seconds, profile.seconds_per_100_bytes]


def test_what_is_stated_is_how_long_it_plays() -> None:
    contents = [packet.to_bytes() for packet in PACKETS]
    assert stated(ufsook_profile()) == pytest.approx([ufsook_waveform([c]).period for c in contents])
    for rate in (30.0, 60.0):
        played = [rs_fsk_waveform([c], rate).period for c in contents]
        assert stated(rs_fsk_profile(rate, 18.9e-6)) == pytest.approx(played)
    for segment_format in (SegmentFormat(1), SegmentFormat(4, frame_rate=60.0)):
        played = [
            segments_waveform(segments_from_packet(c, segment_format.segment_bytes), segment_format).period
            for c in contents
        ]
        assert stated(manchester_profile(segment_format, 18.9e-6, 6e-5)) == pytest.approx(played)


def test_an_id_and_a_command_are_as_fast_as_is_promised() -> None:
    assert ufsook_profile().id_seconds <= 0.9
    assert ufsook_profile().command_seconds <= 5.0


def test_the_paper_s_small_lamp_carries_tones_only() -> None:
    assert rs_fsk_profile(30.0, 18.9e-6).rows_min == 16
    assert 295 <= manchester_profile(SegmentFormat(1), 18.9e-6, 6e-5).rows_min <= 305


@pytest.mark.parametrize('segment_bytes', [1, 2])
def test_manchester_needs_the_rows_that_are_stated(segment_bytes: int) -> None:
    segment_format = SegmentFormat(segment_bytes)
    rows_min = manchester_profile(segment_format, 18.9e-6, 6e-5).rows_min
    waveform = segments_waveform(segments_from_packet(PACKETS[1].to_bytes(), segment_bytes), segment_format)
    counts = {}
    for rows in (rows_min, rows_min * 9 // 10):
        seen = seen_by_rolling_shutter(waveform, 12.0, np.random.default_rng(0), rows=rows)
        counts[rows] = len(ManchesterDecoder(segment_format).add_frames(seen))
    assert counts[rows_min] >= 0.9 * 12.0 / waveform.period - 1
    assert counts[rows_min * 9 // 10] == 0


@pytest.mark.parametrize('row_time', [9e-6, 18.9e-6])
def test_rs_fsk_does_with_the_rows_that_are_stated(row_time: float) -> None:
    rows_min = rs_fsk_profile(30.0, row_time).rows_min
    waveform = rs_fsk_waveform([PACKETS[0].to_bytes()], 30.0, 1.0001)
    channel = {'rows': rows_min, 'row_time': row_time}
    seen = seen_by_rolling_shutter(waveform, 30.0, np.random.default_rng(0), **channel)
    got = RsFskDecoder(30.0).add_frames(seen)
    assert len(got) >= 0.9 * 30.0 / 0.6 - 1
