import numpy as np
import pytest

from vlc_beacon.core.light_code.manchester import Slot
from vlc_beacon.core.light_code.reed_solomon_block import SPARE, packet_of_slots, parity_of, slots_of_packet
from vlc_beacon.core.light_code.whitening import whiten
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_error import PacketError


def contents(slots: list[Slot]) -> dict[int, bytes]:
    return {slot.index: slot.content for slot in slots}


def random_packet(length: int) -> DataPacket:
    return DataPacket(np.random.default_rng(length).bytes(length))


@pytest.mark.parametrize('slot_bytes', [1, 2, 4, 8, 32])
@pytest.mark.parametrize('length', [0, 1, 17, 50, 100])
def test_packets_come_back(length: int, slot_bytes: int) -> None:
    packet = random_packet(length)
    assert packet_of_slots(contents(slots_of_packet(packet.to_bytes(), slot_bytes))) == packet
    assert packet_of_slots(contents(slots_of_packet(IdPacket(7).to_bytes(), slot_bytes))) == IdPacket(7)


def test_it_is_a_reed_solomon_code() -> None:
    # Every block of the code, taken as a polynomial, is zero at the first powers of the field's generator.
    def times(a: int, b: int) -> int:
        product = 0
        while b:
            product, a, b = product ^ (a if b & 1 else 0), a << 1, b >> 1
            a ^= 0x11D if a & 0x100 else 0
        return product

    block = whiten(b''.join(contents(slots_of_packet(random_packet(60).to_bytes(), 1)).values()))
    root = 1
    for _ in range(parity_of(len(block))):
        value = 0
        for byte in block:
            value = times(value, root) ^ byte
        assert value == 0
        root = times(root, 2)


@pytest.mark.parametrize('slot_bytes', [1, 2])
def test_slots_may_be_missing(slot_bytes: int) -> None:
    packet = random_packet(90)
    slots = contents(slots_of_packet(packet.to_bytes(), slot_bytes))
    can_miss = (parity_of(len(slots) * slot_bytes) - SPARE) // slot_bytes
    rng = np.random.default_rng(0)
    for _ in range(20):
        missing = 1 + rng.choice(len(slots) - 1, can_miss + 1, replace=False)
        fewer = {i: content for i, content in slots.items() if i not in missing[:-1]}
        assert packet_of_slots(fewer) == packet
        del fewer[int(missing[-1])]
        assert packet_of_slots(fewer) is None


def test_damaged_slots_are_mended_or_nothing_is_read() -> None:
    packet = random_packet(90)
    slots = contents(slots_of_packet(packet.to_bytes(), 1))
    for seed in range(40):
        rng = np.random.default_rng(seed)
        damaged = dict(slots)
        for i in 1 + rng.choice(len(slots) - 1, seed, replace=False):
            damaged[int(i)] = bytes([damaged[int(i)][0] ^ int(rng.integers(1, 256))])
        got = packet_of_slots(damaged)
        assert got == packet if 2 * seed <= parity_of(len(slots)) else got is None


def test_without_the_first_slot_nothing_is_known() -> None:
    slots = contents(slots_of_packet(IdPacket(7).to_bytes(), 1))
    del slots[0]
    assert packet_of_slots(slots) is None
    assert packet_of_slots({}) is None


def test_slots_of_chance_are_no_packet() -> None:
    rng = np.random.default_rng(1)
    for _ in range(500):
        count = int(rng.integers(1, 40))
        slots = {i: rng.bytes(1) for i in range(count)}
        slots[0] = whiten(bytes([count]))
        assert packet_of_slots(slots) is None


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(PacketError, match='packet has 250 bytes, too many for segments of 1 bytes'):
        slots_of_packet(bytes(250), 1)
