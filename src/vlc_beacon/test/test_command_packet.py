import math
from itertools import combinations

import numpy as np
import pytest

from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.packet.command_packet import (
    COMMAND_BYTES,
    COUNTER_MAX,
    MAC_BYTES,
    SHORT_BYTES,
    WITHOUT_VALUE,
    Command,
    CommandPacket,
    Operation,
    ShortCommandPacket,
    clamp_speed,
    find_implausibility,
    read_command_packet,
    shorten,
)
from vlc_beacon.core.packet.packet_reader import packet_length, read_packet
from vlc_beacon.core.vlc_beacon_error import PacketError


def random_packet(seed: int) -> CommandPacket:
    rng = np.random.default_rng(seed)
    command = Command(
        int(rng.integers(1 << 14)),
        int(rng.integers(16)),
        round(float(rng.uniform(-2000.0, 2000.0)), 6),
        int(rng.integers(COUNTER_MAX + 1)),
        bool(rng.integers(2)),
    )
    return CommandPacket(command, rng.bytes(4))


def test_every_field_comes_back_also_with_the_greatest_value() -> None:
    greatest = CommandPacket(Command(1, 5, 2147.483647, 1), bytes(4))
    for packet in (greatest, *map(random_packet, range(2000))):
        assert len(packet.to_bytes()) == COMMAND_BYTES
        assert read_command_packet(packet.to_bytes()) == packet


def test_up_to_three_wrong_bits_are_noticed() -> None:
    sent = int.from_bytes(random_packet(1).to_bytes())
    triples = np.random.default_rng(0).integers(0, 8 * COMMAND_BYTES, (20_000, 3)).tolist()
    flips = [*combinations(range(8 * COMMAND_BYTES), 2), *[set(t) for t in triples]]
    flips += [(place,) for place in range(8 * COMMAND_BYTES)]
    for places in flips:
        damaged = sent ^ sum(1 << place for place in places)
        assert read_command_packet(damaged.to_bytes(COMMAND_BYTES)) is None


def test_short_packets_carry_the_same_command_and_mac_in_less_time() -> None:
    key, rng = CommandKey(bytes(range(32))), np.random.default_rng(3)
    for operation in (*Operation, *map(int, rng.integers(16, size=2000))):
        value = 0.0 if operation in WITHOUT_VALUE else round(float(rng.uniform(-3.2767, 3.2767)), 4)
        signed = key.sign(
            Command(
                int(rng.integers(1 << 14)), int(operation), value, int(rng.integers(1 << 32)), bool(rng.integers(2))
            )
        )
        short = shorten(signed)
        assert short is not None
        data = short.to_bytes()
        assert len(data) == packet_length(data[:3] + bytes(20)) == (11 if operation in WITHOUT_VALUE else SHORT_BYTES)
        assert read_packet(data) == short
        assert short.addressed_to(signed.command.beacon) == signed
        # The beacon is not sent, but authenticated: another lamp cannot send the command as its own.
        assert not key.is_authentic(short.addressed_to(signed.command.beacon ^ 1))
        assert len(short.mac) == MAC_BYTES == 4
    assert [shorten(key.sign(Command(1, *given, 1))) for given in ((1, 0.5), (5, 3.2768), (5, 0.00001))] == [None] * 3


def test_one_or_two_wrong_bits_of_a_short_packet_are_noticed() -> None:
    for operation, length in ((5, SHORT_BYTES), (1, SHORT_BYTES - 2)):
        sent = int.from_bytes(ShortCommandPacket(Command(0, operation, 0.0, 77), b'abcd').to_bytes())
        for places in [*combinations(range(8 * length), 2), *((place,) for place in range(8 * length))]:
            damaged = sent ^ sum(1 << place for place in places)
            assert read_packet(damaged.to_bytes(length)) is None


def test_each_field_is_signed() -> None:
    fields = {'beacon': 3, 'operation': 3, 'value': 0.2, 'counter': 9, 'is_one_shot': False}
    others = {'beacon': 4, 'operation': 2, 'value': 0.200001, 'counter': 8, 'is_one_shot': True}
    signed = {Command(**{**fields, name: other}).signed_bytes() for name, other in others.items()}
    assert len(signed | {Command(**fields).signed_bytes()}) == 6


@pytest.mark.parametrize(
    ('changed', 'message'),
    [
        ({'beacon': 20000}, 'beacon ID is 20000'),
        ({'operation': 16}, 'operation is 16'),
        ({'counter': -1}, 'counter is -1'),
        ({'counter': 1 << 32}, 'counter is 4294967296'),
        ({'value': 2200.0}, 'value is 2200.0, its size must be below 2147'),
        ({'value': 2147.4836479}, 'value is 2147.4836479, its size must be below 2147'),
        ({'value': -2147.483648}, 'value is -2147.483648, its size must be below 2147'),
        ({'value': float('nan')}, 'value is nan'),
        ({'value': float('inf')}, 'value is inf'),
    ],
)
def test_values_out_of_range_are_rejected(changed: dict[str, float], message: str) -> None:
    with pytest.raises(PacketError, match=message):
        Command(**{'beacon': 1, 'operation': 1, 'value': 0.0, 'counter': 1, **changed})


@pytest.mark.parametrize(
    ('operation', 'value', 'flaw'),
    [
        (Operation.STOP, 0.0, None),
        (Operation.RESUME, 0.0, None),
        (Operation.SLOW, 0.1, None),
        (Operation.SPEED_UP, 0.8, None),
        (Operation.TURN, -math.pi / 2, None),
        (Operation.TURN, 6.28, None),
        (0, 0.0, 'operation 0 is unknown'),
        (15, 0.0, 'operation 15 is unknown'),
        (Operation.STOP, 1.0, 'stop cannot have the value 1'),
        (Operation.SLOW, 0.0, 'slow cannot have the value 0'),
        (Operation.SPEED_UP, -0.5, 'speed_up cannot have the value -0.5'),
        (Operation.TURN, 7.0, 'turn cannot have the value 7'),
    ],
)
def test_what_the_paper_asks_for_is_plausible_and_nonsense_is_named(operation, value, flaw) -> None:
    assert find_implausibility(Command(1, operation, value, 1)) == flaw


def test_no_plausible_speed_exceeds_the_limit() -> None:
    rng = np.random.default_rng(0)
    for _ in range(2000):
        limit = float(rng.uniform(0.0, 2.0))
        command = Command(1, int(rng.integers(16)), float(rng.uniform(-2000.0, 2000.0)), 1)
        if find_implausibility(command) is None:
            bounded = clamp_speed(command, limit)
            if command.operation in (Operation.SLOW, Operation.SPEED_UP):
                assert bounded.value <= limit
            else:
                assert bounded == command
