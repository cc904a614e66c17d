import numpy as np
import pytest
from blake2s_by_the_book import blake2s

from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.packet.command_packet import Command, CommandPacket
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

SECRET = bytes(range(32))


def random_command(seed: int) -> Command:
    rng = np.random.default_rng(seed)
    value = round(float(rng.uniform(-7.0, 7.0)), 6)
    return Command(int(rng.integers(1 << 14)), int(rng.integers(32)), value, int(rng.integers(1 << 32)))


def test_the_second_opinion_knows_the_published_values() -> None:
    # RFC 7693, appendix B, and the first keyed values of the reference implementation's known answers.
    abc = '508c5e8c327c14e2e1a72ba34eeb452f37458b209ed63a294d999b4c86675982'
    assert blake2s(b'abc', b'', 32).hex() == abc
    empty = '48a8997da407876b3d79c0d92325ad3b89cbb754d86ab71aee047ad345fd2c49'
    assert blake2s(b'', SECRET, 32).hex() == empty
    zero = '40d15fee7c328830166ac3f918650f807e7e01e177258cdc0a39b11f598066f1'
    assert blake2s(b'\0', SECRET, 32).hex() == zero


def test_the_code_is_keyed_blake2s() -> None:
    for seed in range(50):
        for secret in (SECRET, SECRET[:16]):
            command = random_command(seed)
            assert CommandKey(secret).sign(command).mac == blake2s(command.signed_bytes(), secret, 4)


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
