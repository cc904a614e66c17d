import numpy as np
import pytest

from shirube_core.crc import crc8
from vlc_beacon.core.packet.data_packet import crc16, crc32

CHECK = b'123456789'


def remainder_of_division(data: bytes, polynomial: int, degree: int) -> int:
    """Divide the message as a polynomial over GF(2), as on paper."""
    value = int.from_bytes(data) << degree
    for place in range(value.bit_length() - 1, degree - 1, -1):
        if value >> place & 1:
            value ^= polynomial << (place - degree)
    return value


def test_check_values_are_those_of_the_catalogue() -> None:
    assert crc8(CHECK) == 0xF4
    assert crc16(CHECK) == 0x31C3
    assert crc32(CHECK) == 0xCBF43926


@pytest.mark.parametrize('length', [1, 2, 15, 100])
def test_it_is_the_remainder_of_a_division(length: int) -> None:
    for seed in range(20):
        data = np.random.default_rng(seed).bytes(length)
        assert crc8(data) == remainder_of_division(data, 0x107, 8)
        assert crc16(data) == remainder_of_division(data, 0x11021, 16)
