import tracemalloc

import numpy as np
import pytest

from vlc_beacon.core.light_code.lamp_rows import rows_from_frame
from vlc_beacon.core.light_code.row_tones import tone_log_likelihoods
from vlc_beacon.core.light_code.rs_fsk import constant_tone_waveform

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


def test_frames_are_independent() -> None:
    rng = np.random.default_rng(0)
    seen = rng.random((5, 20))
    alone = [tone_log_likelihoods(rows_from_frame(0.0, 0, one, 18.9e-6, 6e-5), TONES)[0] for one in seen]
    rows = rows_from_frame(0.0, 0, seen[0], 18.9e-6, 6e-5)
    together = tone_log_likelihoods(type(rows)(np.zeros(5), np.zeros(5, int), seen, 18.9e-6, 6e-5), TONES)
    assert together == pytest.approx(np.array(alone))


def test_lamps_of_many_sizes_take_little_memory() -> None:
    tracemalloc.start()
    for count in range(300, 380):
        tone_log_likelihoods(rows_from_frame(0.0, 0, np.linspace(0.0, 1.0, count), 18.9e-6, 6e-5), TONES)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert held < 10e6
