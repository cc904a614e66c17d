import numpy as np
import pytest

from vlc_beacon.core.light_code.symbol_code import SymbolCode

CODES = [SymbolCode(1, (2, 3), 0.1), SymbolCode(3, (8,), 0.1)]


@pytest.mark.parametrize('code', CODES)
def test_bytes_come_back(code: SymbolCode) -> None:
    for length in range(1, 108):
        packet = np.random.default_rng(length).bytes(length)
        symbols = code.symbols_of(packet)
        assert tuple(symbols[: len(code.marker)]) == code.marker
        assert symbols[len(code.marker) :].max() < code.data_symbols
        assert code.bytes_of(symbols[len(code.marker) :]) == packet
        assert code.seconds_of(length) == pytest.approx(len(symbols) * code.duration)


def test_symbols_that_are_no_whole_bytes_are_nothing() -> None:
    one, three = CODES
    assert one.bytes_of(np.zeros(9, int)) is None
    assert three.bytes_of(np.zeros(4, int)) is None
    # The last symbol is filled up with zeros; anything else is damage.
    symbols = three.symbols_of(b'abcd')[1:]
    symbols[-1] ^= 1
    assert three.bytes_of(symbols) is None
