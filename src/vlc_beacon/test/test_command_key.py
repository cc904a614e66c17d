import numpy as np
import pytest

from vlc_beacon.core.authorization.keys_and_counters import CommandKey
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

SECRET = bytes(range(32))


def random_command(seed: int) -> Command:
    rng = np.random.default_rng(seed)
    value = round(float(rng.uniform(-7.0, 7.0)), 6)
    return Command(int(rng.integers(1 << 14)), int(rng.integers(16)), value, int(rng.integers(1 << 32)))


@pytest.mark.parametrize(
    ('command', 'long', 'short'),
    [
        (Command(4, 3, 0.125, 7), 'a5759c83', '38b6c634'),
        (Command(9, 5, -1.570796, 4_000_000_000, is_one_shot=True), 'f4b9ca77', '3fcba073'),
    ],
)
def test_the_code_is_keyed_blake2s(command: Command, long: str, short: str) -> None:
    """As an implementation written from RFC 7693 alone computes it."""
    assert CommandKey(SECRET).sign(command).mac.hex() == long
    assert CommandKey(SECRET[:16]).sign(command).mac.hex() == short


def test_what_was_signed_is_authentic_and_nothing_else() -> None:
    key = CommandKey(SECRET)
    for seed in range(200):
        packet = key.sign(random_command(seed))
        assert key.is_authentic(packet)
        assert not CommandKey(SECRET[::-1]).is_authentic(packet)
        assert not key.is_authentic(CommandPacket(random_command(seed + 1), packet.mac))
        for bit in range(32):
            mac = (int.from_bytes(packet.mac) ^ 1 << bit).to_bytes(4)
            assert not key.is_authentic(CommandPacket(packet.command, mac))
        assert not key.is_authentic(CommandPacket(packet.command, b''))


@pytest.mark.parametrize('length', [0, 15, 33])
def test_a_key_of_wrong_length_is_rejected(length: int) -> None:
    with pytest.raises(VlcBeaconError, match=f'key has {length} bytes, it must have 16 to 32'):
        CommandKey(bytes(length))
