import numpy as np
import pytest

from vlc_beacon.core.packet.data_packet import DataPacket, MessageAssembler, read_data_packet, split_message
from vlc_beacon.core.vlc_beacon_error import PacketError


def test_every_payload_comes_back() -> None:
    for length in range(101):
        rng = np.random.default_rng(length)
        packet = DataPacket(rng.bytes(length), int(rng.integers(256)), bool(length % 2), bool(length % 3), length % 16)
        assert read_data_packet(packet.to_bytes()) == packet


def test_wrong_bits_are_noticed() -> None:
    sent = DataPacket(b'keep to the left', is_text=True).to_bytes()
    for seed in range(5000):
        rng = np.random.default_rng(seed)
        one_bit = (1 << int(rng.integers(8 * len(sent)))).to_bytes(len(sent))
        damage = rng.bytes(len(sent)) if seed % 2 else one_bit
        assert read_data_packet(bytes(a ^ b for a, b in zip(sent, damage))) is None


@pytest.mark.parametrize('message', ['標はここ', *(bytes(length) for length in (0, 1, 100, 101, 5000))])
def test_a_message_is_its_packets_in_a_row(message: str | bytes) -> None:
    packets, is_text = split_message(message), isinstance(message, str)
    content = b''.join(packet.payload for packet in packets)
    assert content == (message.encode() if is_text else message)
    assert [packet.sequence for packet in packets] == list(range(len(packets)))
    assert [packet.is_last for packet in packets] == [False] * (len(packets) - 1) + [True]
    assert {packet.is_text for packet in packets} == {is_text}
    assert len({packet.tag for packet in packets}) == 1


@pytest.mark.parametrize(
    ('make', 'complaint'),
    [
        (lambda: split_message(bytes(25601)), 'message has 25601 bytes, up to 25600 can be sent'),
        (lambda: DataPacket(bytes(101)), 'payload has 101 bytes'),
        (lambda: DataPacket(b'', 256), 'sequence number is 256'),
    ],
)
def test_too_long_messages_are_rejected(make, complaint) -> None:
    with pytest.raises(PacketError, match=complaint):
        make()


A, B = split_message('a' * 150), split_message('b' * 150)


def answers_to(packets):
    """Return what an assembler makes of packets, one after the other."""
    assembly = MessageAssembler()
    return [assembly.add(packet) for packet in packets]


@pytest.mark.parametrize('message', ['', 'Guten Tag', 'ドアが開きます', b'\x00\xff', 'x' * 950, bytes(range(256)) * 3])
def test_a_message_is_reassembled_from_any_first_fragment(message):
    packets = split_message(message)
    mixed = np.random.default_rng(1).permutation(np.array(packets, object))
    for order in (packets, packets[::-1], list(mixed)):
        answers = answers_to(order)
        assert answers[:-1] == [None] * (len(order) - 1)
        assert answers[-1] == message


def test_a_message_is_reported_once_until_it_changes():
    answers = answers_to(A + A + B + A)
    assert [answer for answer in answers if answer is not None] == ['a' * 150, 'b' * 150, 'a' * 150]


def test_parts_of_two_messages_are_not_joined():
    assert answers_to([A[0], B[1], B[0]]) == [None, None, 'b' * 150]
    # Not even text and bytes of equal tags.
    binary = split_message(b'a' * 150)
    assert A[0].tag == binary[0].tag
    assert answers_to([A[0], binary[1], A[1], A[0]]) == [None, None, None, 'a' * 150]


@pytest.mark.parametrize('longer_first', [True, False])
def test_a_part_beyond_the_last_one_is_of_another_message(longer_first):
    long = [DataPacket(b'l', sequence, is_last=sequence == 2) for sequence in range(3)]
    short = [DataPacket(b's', sequence, is_last=sequence == 1) for sequence in range(2)]
    first, second = (long, short) if longer_first else (short, long)
    answers = answers_to([first[-1], second[-1], *second[:-1]])
    assert answers[:2] == [None, None]
    assert answers[-1] == b''.join(part.payload for part in second)
