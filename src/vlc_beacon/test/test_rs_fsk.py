import numpy as np
import pytest
from flicker import worst_flicker

from vlc_beacon.core.light_code.rs_fsk import (
    PREAMBLE_SYMBOL,
    constant_tone_waveform,
    rs_fsk_code,
    rs_fsk_waveform,
    symbol_tones,
)


@pytest.mark.parametrize('frame_rate', [30.0, 60.0])
def test_tones_stand_apart_and_fit_into_a_symbol(frame_rate: float) -> None:
    code = rs_fsk_code(frame_rate)
    tones = np.array(symbol_tones(code))
    assert len(tones) == PREAMBLE_SYMBOL + 1
    assert np.diff(tones).min() >= 200.0
    assert tones * code.duration == pytest.approx(np.round(tones * code.duration))


@pytest.mark.parametrize('frame_rate', [30.0, 60.0])
@pytest.mark.parametrize('content', [b'@\x05\xaa', bytes(12), b'\xff' * 12, b'\x55' * 12])
@pytest.mark.newest_set_only
def test_nothing_blinks_visibly(content: bytes, frame_rate: float) -> None:
    waveform = rs_fsk_waveform([content], frame_rate)
    assert worst_flicker(waveform) < 0.5
    assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5])
    assert np.diff(np.append(waveform.times, waveform.period)).max() < 1e-3


def test_each_symbol_is_its_tone() -> None:
    code = rs_fsk_code(30.0)
    packet = b'@\x05\xaa'
    waveform = rs_fsk_waveform([packet], 30.0)
    for k, symbol in enumerate(code.encode_symbols(packet)):
        inside = (waveform.times >= (k - 1e-6) * code.duration) & (
            waveform.times < (k + 1 - 1e-6) * code.duration
        )
        assert np.count_nonzero(waveform.levels[inside]) / code.duration == pytest.approx(
            symbol_tones(code)[symbol]
        )


def test_a_constant_tone_is_a_square_wave() -> None:
    waveform = constant_tone_waveform(2000.0)
    assert waveform.period == pytest.approx(1.0 / 2000.0)
    assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5])
