from itertools import combinations

import numpy as np
import pytest

from vlc_beacon.core.packet.data_packet import BEACON_ID_MAX, IdPacket, read_id_packet
from vlc_beacon.core.vlc_beacon_error import PacketError


def test_every_id_comes_back() -> None:
    for beacon in range(BEACON_ID_MAX + 1):
        assert read_id_packet(IdPacket(beacon).to_bytes()) == IdPacket(beacon)


def test_up_to_three_wrong_bits_are_noticed() -> None:
    sent = int.from_bytes(IdPacket(1234).to_bytes())
    for count in (1, 2, 3):
        for places in combinations(range(24), count):
            damaged = sent ^ sum(1 << place for place in places)
            assert read_id_packet(damaged.to_bytes(3)) is None


def test_false_positive_rate_of_ids_matches_the_checksum() -> None:
    words = np.random.default_rng(0).bytes(3 * 100_000)
    taken = sum(read_id_packet(words[i : i + 3]) is not None for i in range(0, len(words), 3))
    expected = 100_000 / 4 / 256
    assert all(read_id_packet(bytes([0x40, 0, 0, 0])[:length]) is None for length in (0, 1, 2, 4))
    assert abs(taken - expected) < 5.0 * expected**0.5


@pytest.mark.parametrize('beacon', [-1, BEACON_ID_MAX + 1])
def test_an_id_out_of_range_is_rejected(beacon: int) -> None:
    with pytest.raises(PacketError, match=f'beacon ID is {beacon}, it must be from 0 to 16383'):
        IdPacket(beacon)
