import numpy as np
import pytest
from light_channel import seen_by_rolling_shutter

from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.manchester import (
    PREAMBLE,
    Segment,
    SegmentFormat,
    segment_from_bits,
    segments_from_packet,
    segments_waveform,
)
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder, demodulate_rows
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import Packet

COMMAND = CommandPacket(Command(3, 5, -1.570796, 77), b'abcd')
HUNDRED = DataPacket(np.random.default_rng(0).bytes(100))


def received(
    packets: list[Packet],
    seconds: float,
    seed: int,
    ppm: float = 0.0,
    segment_format: SegmentFormat = SegmentFormat(1),  # noqa: B008
    rows: int = 304,
    **channel: float,
) -> list[Packet]:
    segments = [
        segment
        for packet in packets
        for segment in segments_from_packet(packet.to_bytes(), segment_format.segment_bytes)
    ]
    waveform = segments_waveform(segments, segment_format, 1.0 + ppm * 1e-6)
    seen = seen_by_rolling_shutter(waveform, seconds, np.random.default_rng(seed), rows=rows, **channel)
    return [got.packet for got in ManchesterDecoder(segment_format).add_frames(seen)]


@pytest.mark.parametrize('ppm', [-100.0, 0.0, 100.0])
@pytest.mark.parametrize('snr', [15.0, 5.0])
def test_packets_are_read_from_three_hundred_rows(ppm: float, snr: float) -> None:
    got = received([COMMAND], 20.0, 1, ppm, snr=snr)
    assert set(got) == {COMMAND}
    assert len(got) >= 18
    hundred = received([HUNDRED], 18.0, 1, ppm, snr=snr)
    assert set(hundred) == {HUNDRED}
    assert len(hundred) >= 2


def test_more_rows_decode_larger_segments_faster() -> None:
    got = received([HUNDRED], 10.0, 1, 50.0, SegmentFormat(8), rows=1060)
    assert set(got) == {HUNDRED}
    assert len(got) >= 9


def test_lost_frames_are_corrected() -> None:
    got = received([HUNDRED], 40.0, 1, 100.0, lost=0.03)
    assert set(got) == {HUNDRED}
    assert len(got) >= 6


def test_nothing_wrong_is_read_in_noise_or_when_frames_are_mostly_lost() -> None:
    for seed in range(4):
        assert set(received([COMMAND], 20.0, seed, snr=1.5)) <= {COMMAND}
        assert set(received([COMMAND, IdPacket(3)], 30.0, seed, lost=0.5)) <= {COMMAND, IdPacket(3)}
    rng = np.random.default_rng(0)
    noise = LampRows(np.arange(900) / 30.0, np.zeros(900, int), rng.random((900, 304)), 18.9e-6, 6e-5)
    assert ManchesterDecoder(SegmentFormat(1)).add_frames(noise) == []


def test_packets_may_take_turns_and_change() -> None:
    got = received([IdPacket(3), COMMAND], 30.0, 1, 100.0)
    assert set(got) == {IdPacket(3), COMMAND}
    assert min(got.count(IdPacket(3)), got.count(COMMAND)) >= 20


def test_frames_give_the_same_one_by_one_and_together() -> None:
    segment_format = SegmentFormat(1)
    waveform = segments_waveform(segments_from_packet(COMMAND.to_bytes(), 1), segment_format)
    seen = seen_by_rolling_shutter(waveform, 10.0, np.random.default_rng(3), rows=304, lost=0.05)
    decoder, single = ManchesterDecoder(segment_format), []
    for i in range(len(seen.stamps)):
        single += decoder.add_frames(
            LampRows(seen.stamps[[i]], seen.first_rows[[i]], seen.brightness[[i]], 18.9e-6, 6e-5)
        )
    assert len(single) >= 8
    assert ManchesterDecoder(segment_format).add_frames(seen) == single


ROW_TIME, EXPOSURE = 18.9e-6, 6e-5


def views(segment: Segment, segment_format: SegmentFormat, rows: int, clock_scale: float = 1.0) -> LampRows:
    """Return views of a slot that begin everywhere in it."""
    waveform = segments_waveform([segment], segment_format, clock_scale)
    stamps = np.linspace(0.0, segment_format.chips * segment_format.chip_time, 301)
    starts = stamps[:, None] + np.arange(rows) * ROW_TIME
    seen = waveform.exposure_means(starts, EXPOSURE)[..., 0]
    return LampRows(stamps, np.zeros(301, int), seen, ROW_TIME, EXPOSURE)


@pytest.mark.parametrize('segment_bytes', [1, 4])
@pytest.mark.parametrize('clock_scale', [0.9999, 1.0001])
def test_a_segment_is_decoded_at_any_offset(segment_bytes: int, clock_scale: float) -> None:
    segment_format = SegmentFormat(segment_bytes)
    segment = Segment(93, b'\x17\x80\xff\x00'[:segment_bytes])
    rows = segment_format.rows_min(ROW_TIME, EXPOSURE)
    bits, is_clear = demodulate_rows(views(segment, segment_format, rows, clock_scale), segment_format)
    assert is_clear.all()
    assert (bits == segment.chips()[len(PREAMBLE) :: 2]).all()
    assert segment_from_bits(bits[0]) == segment


def test_brightness_and_background_do_not_matter() -> None:
    segment_format, segment = SegmentFormat(1), Segment(7, b'\xa5')
    seen = views(segment, segment_format, 310)
    dim = LampRows(seen.stamps, seen.first_rows, 12.0 + 3.0 * seen.brightness, ROW_TIME, EXPOSURE)
    bits, is_clear = demodulate_rows(dim, segment_format)
    assert is_clear.all()
    assert (bits == demodulate_rows(seen, segment_format)[0]).all()


def test_too_few_rows_and_even_rows_are_not_clear() -> None:
    segment_format, segment = SegmentFormat(1), Segment(7, b'\xa5')
    rows = int(0.9 * segment_format.rows_min(ROW_TIME, EXPOSURE))
    assert not demodulate_rows(views(segment, segment_format, rows), segment_format)[1].any()
    even = LampRows(np.zeros(2), np.zeros(2, int), np.ones((2, 310)), ROW_TIME, EXPOSURE)
    assert not demodulate_rows(even, segment_format)[1].any()
    none = LampRows(np.zeros(0), np.zeros(0, int), np.ones((0, 310)), ROW_TIME, EXPOSURE)
    assert demodulate_rows(none, segment_format)[0].shape == (0, 19)
