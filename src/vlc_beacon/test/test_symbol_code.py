import numpy as np
import pytest

from vlc_beacon.core.light_code.symbol_code import SEQUENCE_BYTES, SymbolCode, whiten

CODES = [SymbolCode(1, (2, 3), 0.1), SymbolCode(3, (8,), 0.1)]


@pytest.mark.parametrize('code', CODES)
def test_bytes_come_back(code: SymbolCode) -> None:
    for length in range(1, 108):
        packet = np.random.default_rng(length).bytes(length)
        symbols = code.encode_symbols(packet)
        assert tuple(symbols[: len(code.preamble)]) == code.preamble
        assert symbols[len(code.preamble) :].max() < code.data_symbols
        assert code.decode_symbols(symbols[len(code.preamble) :]) == packet
        assert code.packet_duration(length) == pytest.approx(len(symbols) * code.duration)


def test_symbols_that_are_no_whole_bytes_are_nothing() -> None:
    one, three = CODES
    assert one.decode_symbols(np.zeros(9, int)) is None
    assert three.decode_symbols(np.zeros(4, int)) is None
    # The last symbol is filled up with zeros; anything else is damage.
    symbols = three.encode_symbols(b'abcd')[1:]
    symbols[-1] ^= 1
    assert three.decode_symbols(symbols) is None


def test_whitening_twice_is_nothing_and_goes_on_as_the_shift_register_does() -> None:
    for length in (0, 1, 17, SEQUENCE_BYTES, SEQUENCE_BYTES + 9):
        data = np.random.default_rng(length).bytes(length)
        assert whiten(whiten(data)) == data
    # Each bit is the sum of those 14 and 15 places before it.
    bits = np.unpackbits(np.frombuffer(whiten(bytes(SEQUENCE_BYTES)), np.uint8))
    assert (bits[15:] == bits[1:-14] ^ bits[:-15]).all()
    # Even content gets as many ones as zeros.
    assert abs(bits.mean() - 0.5) < 3.0 / (8 * SEQUENCE_BYTES) ** 0.5
