import numpy as np

from vlc_beacon.core.light_code.whitening import SEQUENCE_BYTES, whiten


def test_twice_is_nothing() -> None:
    for length in (0, 1, 17, SEQUENCE_BYTES, SEQUENCE_BYTES + 9):
        data = np.random.default_rng(length).bytes(length)
        assert whiten(whiten(data)) == data


def test_it_goes_on_as_the_shift_register_does() -> None:
    """Each bit is the sum of those 14 and 15 places before it."""
    bits = np.unpackbits(np.frombuffer(whiten(bytes(SEQUENCE_BYTES)), np.uint8))
    assert (bits[15:] == bits[1:-14] ^ bits[:-15]).all()
    assert bits.any()


def test_even_content_gets_as_many_ones_as_zeros() -> None:
    ones = np.unpackbits(np.frombuffer(whiten(bytes(SEQUENCE_BYTES)), np.uint8)).mean()
    assert abs(ones - 0.5) < 3.0 / (8 * SEQUENCE_BYTES) ** 0.5
