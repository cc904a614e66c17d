from functools import partial

import light_channel
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
    UfsookDecoder,
    ufsook_waveform,
    waveform_from_symbols,
)
from vlc_beacon.core.packet.data_packet import BEACON_ID_MAX, IdPacket


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
    for symbols in ([SPACE], [MARK], [PREAMBLE_FIRST, PREAMBLE_SECOND]):
        waveform = waveform_from_symbols(np.array(symbols))
        assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize('content', [b'@\x05\xaa', bytes(12), b'\xff' * 12, b'\x55' * 12, b'\x0f\x00' * 6])
def test_nothing_blinks_visibly(content: bytes) -> None:
    waveform = ufsook_waveform([content])
    assert worst_flicker(waveform) < 1.0
    assert worst_flicker(waveform, whole=True) < 0.2
    # Never dark or full for longer than half a cycle of the slowest tone.
    steps = np.diff(np.append(waveform.times, waveform.period))
    assert steps.max() <= 0.5 / 210.0 + 1e-9


@pytest.mark.parametrize('symbols', [[SPACE, MARK], [SPACE] * 4 + [MARK] * 4, [PREAMBLE_FIRST, PREAMBLE_SECOND]])
def test_not_even_the_worst_symbols_make_the_lamp_blink(symbols: list[int]) -> None:
    assert worst_flicker(waveform_from_symbols(np.array(symbols)), whole=True, highest=70.0) < 0.3


def test_no_id_leaves_a_lamp_dark_for_longer_than_it_is_remembered() -> None:
    """To frames that find both halves dark in a space, equal symbols are one long darkness."""
    for beacon in range(BEACON_ID_MAX + 1):
        symbols = UFSOOK.encode_symbols(IdPacket(beacon).to_bytes())
        changes = np.flatnonzero(np.diff(np.tile(symbols, 2)))
        assert np.diff(changes).max() * UFSOOK.duration + 1.0 / FRAME_RATE < COAST_TIME


received = partial(light_channel.received, 'ufsook')


@pytest.mark.parametrize('ppm', [-100.0, 0.0, 100.0])
@pytest.mark.parametrize('exposure', [5e-4, 1e-3])
def test_ids_are_read_at_any_offset_of_the_clocks(ppm: float, exposure: float) -> None:
    seconds, sent, right = 26.0, 0, 0
    for seed in range(6):
        packet = IdPacket(int(np.random.default_rng(seed).integers(1 << 14)))
        got = received([packet], seconds, seed, ppm, exposure=exposure)
        assert set(got) == {packet}
        # The first one may be cut off.
        sent, right = sent + int(seconds * 60 / 52) - 1, right + len(got)
    assert right >= 0.95 * sent


def test_an_exposure_of_any_length_is_understood() -> None:
    for exposure in (2e-5, 1e-4, 2e-3):
        assert received([IdPacket(5)], 15.0, 5, 100.0, exposure=exposure).count(IdPacket(5)) >= 8


def test_invalid_frames_are_skipped() -> None:
    waveform = ufsook_waveform([IdPacket(5).to_bytes()])
    stamps, seen = light_channel.seen_by_global_shutter(waveform, 10.0, np.random.default_rng(6))
    whole = UfsookDecoder().add_frames(stamps, seen, 5e-4)
    more = np.insert(seen, [100, 300], np.nan, axis=0)
    late = np.insert(stamps, [100, 300], stamps[[99, 299]] + 0.001)
    assert UfsookDecoder().add_frames(late, more, 5e-4) == whole
    again = np.repeat(stamps, 2)
    assert UfsookDecoder().add_frames(again, np.repeat(seen, 2, axis=0), 5e-4) == whole


@pytest.mark.parametrize('level', [0.0, 0.5, 1.0, 7.0])
def test_constant_light_gives_no_packets(level: float) -> None:
    rng = np.random.default_rng(7)
    stamps = np.arange(1200) / 60.0
    assert UfsookDecoder().add_frames(stamps, level + rng.normal(0.0, 0.05, (1200, 2)), 5e-4) == []
    assert UfsookDecoder().add_frames(stamps, rng.random((1200, 2)), 5e-4) == []


@pytest.mark.parametrize('snr', [15.0, 5.0])
def test_what_was_played_once_is_read_once(snr: float) -> None:
    # Two equal packets in a row are what an ID is believed for.
    packets = [IdPacket(beacon) for beacon in range(40)]
    for seed in range(6):
        ids = [packet.beacon for packet in received(packets, 34.0, seed, 100.0, snr=snr)]
        assert len(set(ids)) == len(ids)
