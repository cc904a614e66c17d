import numpy as np
import pytest
from flicker import worst_flicker

from vlc_beacon.core.light_code.manchester import (
    PREAMBLE,
    Segment,
    SegmentFormat,
    segment_from_bits,
    segments_waveform,
)
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


def bits_of(segment: Segment) -> np.ndarray:
    return segment.chips()[len(PREAMBLE) :: 2]


def test_segments_round_trip() -> None:
    for seed in range(500):
        rng = np.random.default_rng(seed)
        segment = Segment(int(rng.integers(128)), rng.bytes(int(rng.integers(1, 33))))
        assert segment_from_bits(bits_of(segment)) == segment


def test_the_check_is_that_of_the_catalogue() -> None:
    # CRC-4/INTERLAKEN has the same polynomial; it begins and ends with ones, and its check value is 0xB.
    segment = Segment(0, b'123456789')
    ones_first = Segment(0, bytes([segment.content[0] ^ 0xF0]) + segment.content[1:])
    check = int(''.join(map(str, bits_of(ones_first)[-4:])), 2)
    assert check ^ 0xF == 0xB


def test_one_and_two_bit_errors_of_a_short_segment_are_detected() -> None:
    # The polynomial is primitive: two bits less than 15 apart never cancel.
    bits = bits_of(Segment(5, b'\x3c'))
    for i in range(len(bits)):
        for j in range(i, min(i + 15, len(bits))):
            damaged = bits.copy()
            damaged[list({i, j})] ^= 1
            assert segment_from_bits(damaged) is None


def test_three_equal_chips_are_in_the_preamble_only() -> None:
    for seed in range(300):
        rng = np.random.default_rng(seed)
        chips = Segment(int(rng.integers(128)), rng.bytes(4)).chips()
        around = np.append(chips, chips[:2])
        triples = around[:-2] + around[1:-1] + around[2:]
        # A bit beside the preamble may lengthen its dark or its light, whose beginning stays where it is.
        found = set(np.flatnonzero((triples == 0) | (triples == 3)).tolist())
        assert {0, 3} <= found <= {0, 3, 4, len(chips) - 1}


def test_a_camera_of_the_frame_rate_sees_each_segment_completely() -> None:
    for segment_bytes in (1, 4, 8):
        for frame_rate in (15.0, 30.0, 60.0):
            segment_format = SegmentFormat(segment_bytes, frame_rate=frame_rate)
            view = (segment_format.chips + 2) * segment_format.chip_time
            assert segment_format.segment_seconds >= 1.0 / frame_rate + view - 1e-12


@pytest.mark.parametrize(
    'segment_format',
    [SegmentFormat(1), SegmentFormat(8), SegmentFormat(1, 1 / 6000), SegmentFormat(5, 1 / 6000)],
)
@pytest.mark.parametrize('content', [bytes(6), b'\xff' * 6, b'\x55' * 6, b'\x0f\x00' * 3])
def test_nothing_blinks_visibly(content: bytes, segment_format: SegmentFormat) -> None:
    waveform = segments_waveform(segments_from_packet(content, segment_format.segment_bytes), segment_format)
    assert worst_flicker(waveform, highest=30.0) < 1.0
    assert segment_format.chip_time > 1.0 / 8000.0 or worst_flicker(waveform) < 1.0
    assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5])
    assert np.diff(np.append(waveform.times, waveform.period)).max() <= 4.0 * segment_format.chip_time + 1e-12


@pytest.mark.parametrize('segment_bytes', [0, 9])
def test_segments_that_would_flicker_visibly_are_rejected(segment_bytes: int) -> None:
    with pytest.raises(
        VlcBeaconError, match=f'segment_bytes is {segment_bytes}, it must be from 1 to 8, or the lamp'
    ):
        SegmentFormat(segment_bytes)
    assert SegmentFormat(8).chips * SegmentFormat(8).chip_time < 0.02


@pytest.mark.parametrize('chip_time', [float('nan'), 0.0, 1.0 / 2000.0])
def test_chip_times_out_of_range_are_rejected(chip_time: float) -> None:
    with pytest.raises(VlcBeaconError, match=r'chip_time is .* s, it must be from 0.000125 to 0.000166667 s'):
        SegmentFormat(1, chip_time)
