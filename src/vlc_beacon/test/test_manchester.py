import numpy as np
import pytest
from flicker import worst_flicker

from vlc_beacon.core.light_code.manchester import (
    PARITY_RESERVE,
    PREAMBLE,
    Segment,
    SegmentFormat,
    packet_from_segments,
    parity_size,
    segment_from_bits,
    segments_from_packet,
    segments_waveform,
)
from vlc_beacon.core.light_code.symbol_code import whiten
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket
from vlc_beacon.core.vlc_beacon_error import PacketError, VlcBeaconError


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
    'segment_format', [SegmentFormat(1), SegmentFormat(8), SegmentFormat(1, 1 / 6000), SegmentFormat(5, 1 / 6000)]
)
@pytest.mark.parametrize('content', [bytes(6), b'\xff' * 6, b'\x55' * 6, b'\x0f\x00' * 3])
def test_nothing_blinks_visibly(content: bytes, segment_format: SegmentFormat) -> None:
    waveform = segments_waveform(segments_from_packet(content, segment_format.segment_bytes), segment_format)
    assert worst_flicker(waveform, highest=30.0) < 1.0
    assert segment_format.chip_time > 1.0 / 8000.0 or worst_flicker(waveform) < 1.0
    assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5])
    assert np.diff(np.append(waveform.times, waveform.period)).max() <= 4.0 * segment_format.chip_time + 1e-12


CHIP_TIME = r'chip_time is .* s, it must be from 0.000125 to 0.000166667 s'


@pytest.mark.parametrize(
    ('values', 'complaint'),
    [
        *(((size,), f'segment_bytes is {size}, it must be from 1 to 8, or the lamp') for size in (0, 9)),
        *(((1, chip_time), CHIP_TIME) for chip_time in (float('nan'), 0.0, 1.0 / 2000.0)),
    ],
)
def test_segments_that_would_flicker_visibly_are_rejected(values, complaint: str) -> None:
    with pytest.raises(VlcBeaconError, match=complaint):
        SegmentFormat(*values)
    assert SegmentFormat(8).chips * SegmentFormat(8).chip_time < 0.02


def contents(segments: list[Segment]) -> dict[int, bytes]:
    return {segment.index: segment.content for segment in segments}


def random_packet(length: int) -> DataPacket:
    return DataPacket(np.random.default_rng(length).bytes(length))


@pytest.mark.parametrize('segment_bytes', [1, 2, 4, 8, 32])
@pytest.mark.parametrize('length', [0, 1, 17, 50, 100])
def test_packets_come_back(length: int, segment_bytes: int) -> None:
    for packet in (random_packet(length), IdPacket(7)):
        assert packet_from_segments(contents(segments_from_packet(packet.to_bytes(), segment_bytes))) == packet


def test_it_is_a_reed_solomon_code() -> None:
    # Every block of the code, taken as a polynomial, is zero at the first powers of the field's generator.
    def times(a: int, b: int) -> int:
        product = 0
        while b:
            product, a, b = product ^ (a if b & 1 else 0), a << 1, b >> 1
            a ^= 0x11D if a & 0x100 else 0
        return product

    block = whiten(b''.join(contents(segments_from_packet(random_packet(60).to_bytes(), 1)).values()))
    root = 1
    for _ in range(parity_size(len(block))):
        value = 0
        for byte in block:
            value = times(value, root) ^ byte
        assert value == 0
        root = times(root, 2)


@pytest.mark.parametrize('segment_bytes', [1, 2])
def test_segments_may_be_missing(segment_bytes: int) -> None:
    packet = random_packet(90)
    segments = contents(segments_from_packet(packet.to_bytes(), segment_bytes))
    can_miss = (parity_size(len(segments) * segment_bytes) - PARITY_RESERVE) // segment_bytes
    rng = np.random.default_rng(0)
    for _ in range(20):
        missing = 1 + rng.choice(len(segments) - 1, can_miss + 1, replace=False)
        fewer = {i: content for i, content in segments.items() if i not in missing[:-1]}
        assert packet_from_segments(fewer) == packet
        del fewer[int(missing[-1])]
        assert packet_from_segments(fewer) is None


def test_corrupted_segments_are_corrected_or_rejected() -> None:
    packet = random_packet(90)
    segments = contents(segments_from_packet(packet.to_bytes(), 1))
    for seed in range(40):
        rng = np.random.default_rng(seed)
        damaged = dict(segments)
        for i in 1 + rng.choice(len(segments) - 1, seed, replace=False):
            damaged[int(i)] = bytes([damaged[int(i)][0] ^ int(rng.integers(1, 256))])
        got = packet_from_segments(damaged)
        assert got == packet if 2 * seed <= parity_size(len(segments)) else got is None


def test_random_segments_and_those_without_the_first_are_no_packet() -> None:
    segments = contents(segments_from_packet(IdPacket(7).to_bytes(), 1))
    del segments[0]
    assert packet_from_segments(segments) is packet_from_segments({}) is None
    rng = np.random.default_rng(1)
    for _ in range(500):
        count = int(rng.integers(1, 40))
        segments = {i: rng.bytes(1) for i in range(count)}
        segments[0] = whiten(bytes([count]))
        assert packet_from_segments(segments) is None


def test_values_out_of_range_are_rejected() -> None:
    with pytest.raises(PacketError, match='packet has 250 bytes, too many for segments of 1 bytes'):
        segments_from_packet(bytes(250), 1)
