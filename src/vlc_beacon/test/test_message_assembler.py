import numpy as np
import pytest

from vlc_beacon.core.packet.data_packet import DataPacket, split_message
from vlc_beacon.core.packet.message_assembler import MessageAssembler


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
