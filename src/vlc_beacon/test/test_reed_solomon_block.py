import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import Segment
from vlc_beacon.core.light_code.reed_solomon_block import (
    PARITY_RESERVE,
    packet_from_segments,
    parity_size,
    segments_from_packet,
)
from vlc_beacon.core.light_code.whitening import whiten
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_error import PacketError


def contents(segments: list[Segment]) -> dict[int, bytes]:
    return {segment.index: segment.content for segment in segments}


def random_packet(length: int) -> DataPacket:
    return DataPacket(np.random.default_rng(length).bytes(length))


@pytest.mark.parametrize('segment_bytes', [1, 2, 4, 8, 32])
@pytest.mark.parametrize('length', [0, 1, 17, 50, 100])
def test_packets_come_back(length: int, segment_bytes: int) -> None:
    packet = random_packet(length)
    assert packet_from_segments(contents(segments_from_packet(packet.to_bytes(), segment_bytes))) == packet
    assert packet_from_segments(
        contents(segments_from_packet(IdPacket(7).to_bytes(), segment_bytes))
    ) == IdPacket(7)


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


def test_without_the_first_segment_nothing_is_decoded() -> None:
    segments = contents(segments_from_packet(IdPacket(7).to_bytes(), 1))
    del segments[0]
    assert packet_from_segments(segments) is None
    assert packet_from_segments({}) is None


def test_random_segments_are_no_packet() -> None:
    rng = np.random.default_rng(1)
    for _ in range(500):
        count = int(rng.integers(1, 40))
        segments = {i: rng.bytes(1) for i in range(count)}
        segments[0] = whiten(bytes([count]))
        assert packet_from_segments(segments) is None


def test_values_out_of_range_are_rejected() -> None:
    with pytest.raises(PacketError, match='packet has 250 bytes, too many for segments of 1 bytes'):
        segments_from_packet(bytes(250), 1)
