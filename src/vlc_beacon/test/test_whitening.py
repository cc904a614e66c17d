import numpy as np

from vlc_beacon.core.light_code.whitening import LENGTH, whiten


def test_twice_is_nothing() -> None:
    for length in (0, 1, 17, LENGTH, LENGTH + 9):
        data = np.random.default_rng(length).bytes(length)
        assert whiten(whiten(data)) == data


def test_it_begins_as_the_shift_register_does() -> None:
    # x^15 + x^14 + 1 from all ones: 14 zeros and a one go round after the first feedback.
    assert whiten(bytes(4)) == bytes([0b00000000, 0b00000010, 0b00000000, 0b00001100])


def test_even_content_gets_as_many_ones_as_zeros() -> None:
    ones = np.unpackbits(np.frombuffer(whiten(bytes(LENGTH)), np.uint8)).mean()
    assert abs(ones - 0.5) < 3.0 / (8 * LENGTH) ** 0.5
