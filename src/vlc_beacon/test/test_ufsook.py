import numpy as np
import pytest
from flicker import worst_flicker

from vlc_beacon.core.lamp_image.lamp_tracker import COAST_TIME
from vlc_beacon.core.light_code.ufsook import (
    FRAME_RATE,
    MARK,
    PREAMBLE_FIRST,
    PREAMBLE_SECOND,
    SPACE,
    UFSOOK,
    expected_levels,
    ufsook_waveform,
    waveform_from_symbols,
)
from vlc_beacon.core.packet.id_packet import BEACON_ID_MAX, IdPacket


def cycles_a_second(symbol: int) -> float:
    """Return how often a half goes on in a second of a symbol."""
    waveform = waveform_from_symbols(np.full(30, symbol))
    rises = np.count_nonzero(np.diff(np.append(waveform.levels[-1, 0], waveform.levels[:, 0])) > 0)
    return rises / waveform.period


def test_space_mark_and_preamble_have_their_frequencies() -> None:
    assert cycles_a_second(SPACE) == pytest.approx(240.0)
    assert cycles_a_second(MARK) == pytest.approx(210.0)
    preamble = waveform_from_symbols(np.array([PREAMBLE_FIRST, PREAMBLE_SECOND]))
    assert np.count_nonzero(np.diff(preamble.levels[:, 1]) > 0) / preamble.period == pytest.approx(225.0)


def test_space_looks_steady_and_mark_toggles() -> None:
    for exposure in (1e-4, 1e-3):
        starts = np.linspace(0.0, 1.0 / FRAME_RATE - exposure, 50)
        for symbol, sign in ((SPACE, 1.0), (MARK, -1.0)):
            waveform = waveform_from_symbols(np.array([symbol]))
            first = waveform.exposure_means(starts, exposure) - 0.5
            second = waveform.exposure_means(starts + 1.0 / FRAME_RATE, exposure) - 0.5
            assert second == pytest.approx(sign * first, abs=1e-9)


def test_the_second_half_runs_a_quarter_of_a_cycle_ahead() -> None:
    waveform = waveform_from_symbols(np.array([SPACE]))
    times = np.linspace(0.0, 0.1, 300)
    quarter = 1.0 / 240.0 / 4.0
    seen = waveform.exposure_means(times, 1e-5)[:, 1]
    assert seen == pytest.approx(waveform.exposure_means(times + quarter, 1e-5)[:, 0])


def test_the_mean_light_is_half_of_full_light() -> None:
    for symbol in (SPACE, MARK):
        waveform = waveform_from_symbols(np.array([symbol]))
        assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5, 0.5])
    both = waveform_from_symbols(np.array([PREAMBLE_FIRST, PREAMBLE_SECOND]))
    assert both.exposure_means(0.0, both.period) == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize('content', [b'@\x05\xaa', bytes(12), b'\xff' * 12, b'\x55' * 12, b'\x0f\x00' * 6])
def test_nothing_blinks_visibly(content: bytes) -> None:
    waveform = ufsook_waveform([content])
    assert worst_flicker(waveform) < 1.0
    assert worst_flicker(waveform, whole=True) < 0.2
    # Never dark or full for longer than half a cycle of the slowest tone.
    steps = np.diff(np.append(waveform.times, waveform.period))
    assert steps.max() <= 0.5 / 210.0 + 1e-9


@pytest.mark.parametrize(
    'symbols', [[SPACE, MARK], [SPACE] * 4 + [MARK] * 4, [PREAMBLE_FIRST, PREAMBLE_SECOND]]
)
def test_not_even_the_worst_symbols_make_the_lamp_blink(symbols: list[int]) -> None:
    assert worst_flicker(waveform_from_symbols(np.array(symbols)), whole=True, highest=70.0) < 0.3


def test_expected_levels_are_those_of_the_waveform() -> None:
    means, variances = expected_levels(5e-4, 120, 0.0)
    starts = (np.arange(120) + 0.5) / 120 * UFSOOK.duration
    inside = starts < UFSOOK.duration - 5e-4
    for symbol in (SPACE, MARK):
        seen = waveform_from_symbols(np.array([symbol])).exposure_means(starts, 5e-4)
        assert means[symbol] == pytest.approx(seen)
    preamble = waveform_from_symbols(np.array([PREAMBLE_FIRST, PREAMBLE_SECOND]))
    assert means[PREAMBLE_FIRST][inside] == pytest.approx(preamble.exposure_means(starts, 5e-4)[inside])
    later = preamble.exposure_means(starts + UFSOOK.duration, 5e-4)
    assert means[PREAMBLE_SECOND][inside] == pytest.approx(later[inside])
    assert variances == pytest.approx(0.0, abs=1e-12)


def test_uncertain_times_blur_the_edges_only() -> None:
    means, variances = expected_levels(1e-4, 240, 1e-4)
    sharp, _ = expected_levels(1e-4, 240, 0.0)
    assert np.abs(means - sharp).max() > 0.1
    assert np.median(variances) < 1e-9 < 0.05 < variances.max()


def test_no_id_leaves_a_lamp_dark_for_longer_than_it_is_remembered() -> None:
    """To frames that find both halves dark in a space, equal symbols are one long darkness."""
    for beacon in range(BEACON_ID_MAX + 1):
        symbols = UFSOOK.encode_symbols(IdPacket(beacon).to_bytes())
        changes = np.flatnonzero(np.diff(np.tile(symbols, 2)))
        assert np.diff(changes).max() * UFSOOK.duration + 1.0 / FRAME_RATE < COAST_TIME
