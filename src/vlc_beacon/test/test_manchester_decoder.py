from functools import partial

import light_channel
import numpy as np
import pytest
from light_channel import COMMAND, HUNDRED

from vlc_beacon.core.lamp_image.row_profile import LampRows
from vlc_beacon.core.light_code.manchester import PREAMBLE, Segment, SegmentFormat, segment_from_bits, segments_waveform
from vlc_beacon.core.light_code.manchester_decoder import ManchesterDecoder, demodulate_rows

received = partial(light_channel.received, 'manchester')


@pytest.mark.parametrize('ppm', [-100.0, 0.0, 100.0])
@pytest.mark.parametrize('snr', [15.0, 5.0])
def test_packets_are_read_from_three_hundred_rows(ppm: float, snr: float) -> None:
    got = received([COMMAND], 20.0, 1, ppm, snr=snr)
    assert set(got) == {COMMAND}
    assert len(got) >= 18
    hundred = received([HUNDRED], 18.0, 1, ppm, snr=snr)
    assert set(hundred) == {HUNDRED}
    assert len(hundred) >= 2


@pytest.mark.parametrize(
    ('seconds', 'ppm', 'segments', 'channel', 'least'),
    [(10.0, 50.0, SegmentFormat(8), {'rows': 1060}, 9), (40.0, 100.0, SegmentFormat(1), {'lost': 0.03}, 6)],
    ids=['more rows decode larger segments faster', 'lost frames are corrected'],
)
def test_a_hundred_bytes_are_read(seconds, ppm, segments, channel, least) -> None:
    got = received([HUNDRED], seconds, 1, ppm, segments, **channel)
    assert set(got) == {HUNDRED}
    assert len(got) >= least


def test_noise_alone_gives_no_packets() -> None:
    rng = np.random.default_rng(0)
    noise = LampRows(np.arange(900) / 30.0, np.zeros(900, int), rng.random((900, 304)), 18.9e-6, 6e-5)
    assert ManchesterDecoder(SegmentFormat(1)).add_frames(noise) == []


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
    even, none = (LampRows(np.zeros(n), np.zeros(n, int), np.ones((n, 310)), ROW_TIME, EXPOSURE) for n in (2, 0))
    assert not demodulate_rows(even, segment_format)[1].any()
    assert demodulate_rows(none, segment_format)[0].shape == (0, 19)
