import numpy as np
import pytest

from vlc_beacon.core.packet.data_packet import DataPacket, MessageAssembler, read_data_packet, split_message
from vlc_beacon.core.vlc_beacon_error import PacketError


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


@pytest.mark.parametrize(
    'message', ['', 'Guten Tag', 'ドアが開きます', b'\x00\xff', 'x' * 950, bytes(range(256)) * 3]
)
def test_a_message_is_reassembled_from_any_first_fragment(message):
    packets = split_message(message)
    for order in (
        packets,
        packets[::-1],
        list(np.random.default_rng(1).permutation(np.array(packets, object))),
    ):
        assembly = MessageAssembler()
        answers = [assembly.add(packet) for packet in order]
        assert answers[:-1] == [None] * (len(order) - 1)
        assert answers[-1] == message


def test_a_message_is_reported_once_until_it_changes():
    assembly = MessageAssembler()
    told = [
        assembly.add(packet)
        for message in ('a' * 150, 'a' * 150, 'b' * 150, 'a' * 150)
        for packet in split_message(message)
    ]
    assert [answer for answer in told if answer is not None] == ['a' * 150, 'b' * 150, 'a' * 150]


def test_parts_of_two_messages_are_not_joined():
    first, second = split_message('a' * 150), split_message('b' * 150)
    assembly = MessageAssembler()
    assert assembly.add(first[0]) is None
    assert assembly.add(second[1]) is None
    assert assembly.add(second[0]) == 'b' * 150


def test_text_and_bytes_of_equal_tags_are_not_joined():
    text, binary = split_message('a' * 150), split_message(b'a' * 150)
    assert text[0].tag == binary[0].tag
    assembly = MessageAssembler()
    assert assembly.add(text[0]) is None
    assert assembly.add(binary[1]) is None
    assert assembly.add(text[1]) is None
    assert assembly.add(text[0]) == 'a' * 150


@pytest.mark.parametrize('longer_first', [True, False])
def test_a_part_beyond_the_last_one_is_of_another_message(longer_first):
    long = [DataPacket(b'l', sequence, is_last=sequence == 2) for sequence in range(3)]
    short = [DataPacket(b's', sequence, is_last=sequence == 1) for sequence in range(2)]
    first, second = (long, short) if longer_first else (short, long)
    assembly = MessageAssembler()
    assert assembly.add(first[-1]) is None
    assert assembly.add(second[-1]) is None
    answers = [assembly.add(part) for part in second[:-1]]
    assert answers[-1] == b''.join(part.payload for part in second)
