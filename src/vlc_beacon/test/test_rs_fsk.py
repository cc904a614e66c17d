import tracemalloc
from functools import partial

import light_channel
import numpy as np
import pytest
from flicker import worst_flicker
from light_channel import one_by_one, seen_by_rolling_shutter

from vlc_beacon.core.lamp_image.row_profile import LampRows, rows_from_frame
from vlc_beacon.core.light_code.rs_fsk import (
    PREAMBLE_SYMBOL,
    RsFskDecoder,
    ToneDecoder,
    constant_tone_waveform,
    rs_fsk_code,
    rs_fsk_waveform,
    symbol_tones,
    tone_log_likelihoods,
)
from vlc_beacon.core.packet.data_packet import IdPacket


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
    code, packet = rs_fsk_code(30.0), b'@\x05\xaa'
    waveform = rs_fsk_waveform([packet], 30.0)
    for k, symbol in enumerate(code.encode_symbols(packet)):
        inside = np.floor(waveform.times / code.duration + 1e-6) == k
        rate = np.count_nonzero(waveform.levels[inside]) / code.duration
        assert rate == pytest.approx(symbol_tones(code)[symbol])


def test_a_constant_tone_is_a_square_wave() -> None:
    waveform = constant_tone_waveform(2000.0)
    assert waveform.period == pytest.approx(1.0 / 2000.0)
    assert waveform.exposure_means(0.0, waveform.period) == pytest.approx([0.5])


TONES = (3500.0, 4000.0, 5000.0, 7000.0)


@pytest.mark.parametrize('tone', TONES)
def test_the_tone_that_plays_is_the_likeliest_whatever_the_brightness(tone: float) -> None:
    for phase in np.linspace(0.0, 1.0, 7):
        starts = phase / tone + np.arange(20) * 18.9e-6
        seen = constant_tone_waveform(tone).exposure_means(starts, 6e-5)[:, 0]
        for gain, offset in ((1.0, 0.0), (180.0, 40.0)):
            rows = rows_from_frame(0.0, 0, offset + gain * seen, 18.9e-6, 6e-5)
            (likelihoods,) = tone_log_likelihoods(rows, TONES)
            assert likelihoods.argmax() == TONES.index(tone)
            assert likelihoods.max() == 0.0


def test_lamps_of_many_sizes_take_little_memory() -> None:
    tracemalloc.start()
    for count in range(300, 380):
        tone_log_likelihoods(rows_from_frame(0.0, 0, np.linspace(0.0, 1.0, count), 18.9e-6, 6e-5), TONES)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert held < 10e6


received = partial(light_channel.received, 'rs_fsk')


@pytest.mark.parametrize('ppm', [-100.0, 0.0, 100.0])
def test_ids_are_read_from_sixteen_rows(ppm: float) -> None:
    sent, right = 0, 0
    for seed in range(6):
        packet = IdPacket(int(np.random.default_rng(seed).integers(1 << 14)))
        got = received([packet], 18.0, seed, ppm)
        assert set(got) == {packet}
        sent, right = sent + 29, right + len(got)
    assert right >= 0.9 * sent


def test_a_faster_camera_and_faster_rows_do_as_well() -> None:
    assert received([IdPacket(5)], 12.0, 1, 100.0, frame_rate=60.0).count(IdPacket(5)) >= 34
    assert received([IdPacket(5)], 12.0, 1, 100.0, rows=34, row_time=9e-6).count(IdPacket(5)) >= 16


def test_constant_light_and_too_few_rows_give_no_packets() -> None:
    rng = np.random.default_rng(7)
    for rows, noise in ((3, 0.05), (16, 0.05), (16, 0.0)):
        seen = 0.5 + rng.normal(0.0, noise, (600, rows))
        frames = LampRows(np.arange(600) / 30.0, np.zeros(600, int), seen, 18.9e-6, 6e-5)
        assert RsFskDecoder(30.0).add_frames(frames) == []


@pytest.mark.parametrize('spacing', [200.0, 500.0])
def test_constant_tones_are_identified(spacing: float) -> None:
    # The real photograph's lamps: 2000 to 4000 Hz on a phone.
    tones = {beacon: 2000.0 + spacing * beacon for beacon in range(5)}
    for beacon, tone in tones.items():
        rng = np.random.default_rng(beacon)
        rows = seen_by_rolling_shutter(constant_tone_waveform(tone), 3.0, rng, rows=40)
        decoder = ToneDecoder(tones)
        answers = [decoder.add_frames(frame) for frame in one_by_one(rows)]
        assert set(answers) - {None} == {beacon}
        assert len(answers) - answers.count(None) >= 3


@pytest.mark.parametrize('rows', [16, 40])
@pytest.mark.parametrize('tone', [600.0, 2600.0, 4600.0, 6000.0, 8000.0])
def test_a_foreign_tone_is_no_beacons(tone: float, rows: int) -> None:
    decoder, waveform = ToneDecoder({1: 4100.0, 2: 5100.0}), constant_tone_waveform(tone)
    for snr in (5.0, 30.0):
        seen = seen_by_rolling_shutter(waveform, 5.0, np.random.default_rng(1), rows=rows, snr=snr)
        assert {decoder.add_frames(frame) for frame in one_by_one(seen)} == {None}
