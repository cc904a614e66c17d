import numpy as np
import pytest

from vlc_beacon.core.packet.data_packet import DataPacket, read_data_packet, split_message
from vlc_beacon.core.packet.packet_error import PacketError


def test_every_payload_comes_back() -> None:
    for length in range(101):
        rng = np.random.default_rng(length)
        packet = DataPacket(
            rng.bytes(length), int(rng.integers(256)), bool(length % 2), bool(length % 3), length % 16
        )
        assert read_data_packet(packet.to_bytes()) == packet


def test_wrong_bits_are_noticed() -> None:
    sent = DataPacket(b'keep to the left', is_text=True).to_bytes()
    for seed in range(5000):
        rng = np.random.default_rng(seed)
        damage = (
            rng.bytes(len(sent)) if seed % 2 else (1 << int(rng.integers(8 * len(sent)))).to_bytes(len(sent))
        )
        damaged = bytes(a ^ b for a, b in zip(sent, damage))
        assert read_data_packet(damaged) is None


@pytest.mark.parametrize('length', [0, 1, 100, 101, 5000])
def test_a_message_is_its_packets_in_a_row(length: int) -> None:
    message = np.random.default_rng(length).bytes(length)
    packets = split_message(message)
    assert b''.join(packet.payload for packet in packets) == message
    assert [packet.sequence for packet in packets] == list(range(len(packets)))
    assert [packet.is_last for packet in packets] == [False] * (len(packets) - 1) + [True]
    assert not any(packet.is_text for packet in packets)
    assert len({packet.tag for packet in packets}) == 1


def test_text_is_marked_and_sent_in_utf_8() -> None:
    (packet,) = split_message('標はここ')
    assert packet.is_text
    assert packet.payload.decode() == '標はここ'


def test_too_long_messages_are_rejected() -> None:
    with pytest.raises(PacketError, match='message has 25601 bytes, up to 25600 can be sent'):
        split_message(bytes(25601))
    with pytest.raises(PacketError, match='payload has 101 bytes'):
        DataPacket(bytes(101))
    with pytest.raises(PacketError, match='sequence number is 256'):
        DataPacket(b'', 256)
