import numpy as np

from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.packet.data_packet import IdPacket

CODE = SymbolCode(2, (4,), 0.1)


def told_symbols(packets: list[IdPacket], begin: float, stamps: np.ndarray) -> np.ndarray:
    """Return tables of frames each of which tells its symbol for sure, shape (n, 1, 5)."""
    symbols = np.concatenate([CODE.encode_symbols(packet.to_bytes()) for packet in packets])
    index = np.floor((stamps - begin) / CODE.duration).astype(int) % len(symbols)
    return -8.0 * (symbols[index, None] != np.arange(5))[:, None].astype(np.float32)


def receiver() -> SymbolReceiver:
    return SymbolReceiver(CODE, symbols=5, bins=1, candidates=20)


STAMPS = np.arange(600) * 0.033
TABLES = told_symbols([IdPacket(7)], 0.02, STAMPS)


def test_packets_are_known_a_little_after_their_end() -> None:
    got = receiver().add(STAMPS, TABLES)
    assert {packet.packet for packet in got} == {IdPacket(7)}
    # A packet is known once the marker after it is over, in the next frame or the one after.
    ends = np.array([packet.stamp for packet in got]) - 0.02 - CODE.duration
    late = (ends + 0.03) % (13 * CODE.duration) - 0.03
    assert (late < 0.08).all()
    assert len(got) >= 13


def test_the_receiver_is_reset_after_a_gap() -> None:
    listener, later = receiver(), STAMPS + 100.0
    later_tables = told_symbols([IdPacket(8)], 100.07, later)
    first, second = listener.add(STAMPS, TABLES), listener.add(later, later_tables)
    assert {packet.packet for packet in first} == {IdPacket(7)}
    assert {packet.packet for packet in second} == {IdPacket(8)}
    together = np.append(STAMPS, later), np.concatenate([TABLES, later_tables])
    assert receiver().add(*together) == first + second


def test_a_changed_timing_is_found() -> None:
    stamps = np.arange(900) * 0.033
    tables = told_symbols([IdPacket(7)], 0.02, stamps)
    shifted = told_symbols([IdPacket(7)], 0.07, stamps)
    got = receiver().add(stamps, np.concatenate([tables[:450], shifted[450:]]))
    assert {packet.packet for packet in got} == {IdPacket(7)}
    assert max(packet.stamp for packet in got) > stamps[-60]


def test_repeated_frames_give_no_packet_twice() -> None:
    # Two equal packets in a row are what an ID is believed for.
    stamps = np.arange(1200) * 0.033
    packets = [IdPacket(beacon) for beacon in range(40)]
    for shift in (0.03, 0.05, 0.07):
        first, second = (told_symbols(packets, begin, stamps) for begin in (0.02, 0.02 + shift))
        got = receiver().add(stamps, np.concatenate([first[:600], second[600:]]))
        ids = [packet.packet.beacon for packet in got]
        assert len(set(ids)) == len(ids) >= 20


def test_a_clock_that_drifts_is_followed() -> None:
    stamps = np.arange(3000) * 0.033
    got = receiver().add(stamps * 1.0005, told_symbols([IdPacket(7)], 0.02, stamps))
    assert len(got) >= 70
    assert {packet.packet for packet in got} == {IdPacket(7)}


def test_time_that_does_not_rise_is_left_out() -> None:
    order = np.sort(np.append(np.arange(600), [50, 50, 300]))
    back = STAMPS[order]
    back[52] = -5.0
    assert receiver().add(back, TABLES[order]) == receiver().add(STAMPS, TABLES)
    assert receiver().add(np.zeros(0), TABLES[:0]) == []


def test_the_checksum_resolves_ambiguous_symbols() -> None:
    tables = TABLES.copy()
    index = np.floor((STAMPS - 0.02) / CODE.duration).astype(int) % 13
    symbols = CODE.encode_symbols(IdPacket(7).to_bytes())
    tables[index == 4, 0, (symbols[4] + 1) % 4] = 0.0
    assert {packet.packet for packet in receiver().add(STAMPS, tables)} == {IdPacket(7)}
    # Two such symbols of an ID are too many for its checksum.
    tables[index == 7, 0, (symbols[7] + 1) % 4] = 0.0
    assert receiver().add(STAMPS, tables) == []
