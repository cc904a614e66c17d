"""Integers are those of C on the microcontroller."""

import pytest

from motor_bridge.emulator.firmware import atoi, divide_truncating, wrap_signed


@pytest.mark.parametrize(
    ('text', 'number'),
    [
        *[('12', 12), ('-7', -7), ('+3', 3), (' 4', 4), ('5x', 5), ('', 0), ('-', 0)],
        *[('nan', 0), ('1e3', 1), ('32767', 32767), ('32768', -32768), ('65537', 1), ('-40000', 25536)],
    ],
)
def test_numbers_are_read_as_by_the_microcontroller(text, number):
    assert atoi(text) == number


def test_division_cuts_towards_zero():
    assert [divide_truncating(n, 50) for n in (-99, -50, -49, 0, 49, 50, 99)] == [-1, -1, 0, 0, 0, 1, 1]
    assert divide_truncating(5, 0) == 0


@pytest.mark.parametrize('bits', [16, 32])
def test_wrapping_keeps_what_fits_and_goes_round(bits):
    top = 1 << (bits - 1)
    assert wrap_signed(top - 1, bits) == top - 1
    assert wrap_signed(top, bits) == -top
    assert wrap_signed(3 * top + 5, bits) == wrap_signed(-top + 5, bits)
