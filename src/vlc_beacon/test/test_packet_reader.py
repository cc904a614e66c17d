import numpy as np

from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket, IdPacket
from vlc_beacon.core.packet.packet_reader import packet_length, read_packet

PACKETS = (
    IdPacket(77),
    CommandPacket(Command(3, 1, 0.0, 5), b'abcd'),
    DataPacket(b'', is_text=True),
    DataPacket(b'hello'),
    DataPacket(bytes(100)),
)


def test_packet_kinds_are_distinguished_and_their_length_is_known_from_the_beginning() -> None:
    for packet in PACKETS:
        content = packet.to_bytes()
        assert read_packet(content) == packet
        assert packet_length(content[:3] + bytes(200)) == len(content)
    assert packet_length(b'') is None
    assert packet_length(bytes(20)) is None


def test_darkness_and_full_light_are_no_packets() -> None:
    for length in range(110):
        assert read_packet(bytes(length)) is read_packet(b'\xff' * length) is None


def test_random_bytes_never_raise() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20_000):
        read_packet(rng.bytes(int(rng.integers(1, 20))))
