import numpy as np
import pytest

from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.light_code.manchester import SegmentFormat, segments_waveform
from vlc_beacon.core.light_code.reed_solomon_block import segments_from_packet
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.receiver.row_timing import row_timing
from vlc_beacon.core.receiver.settings import ReceiverSettings

PACKET = np.random.default_rng(1).bytes(40)


def longest_dark(waveform) -> float:
    """Return the longest time without light [s]."""
    steps = np.diff(np.append(waveform.times, waveform.period))
    runs, run = [0.0], 0.0
    for level, step in zip(np.tile(waveform.levels[:, 0], 2), np.tile(steps, 2), strict=True):
        run = run + step if level == 0.0 else 0.0
        runs.append(run)
    return max(runs)


@pytest.mark.parametrize('row_time', [9e-6, 18.9e-6])
@pytest.mark.parametrize('is_large', [False, True])
def test_no_dark_stripe_of_the_codes_is_longer_than_expected(row_time: float, is_large: bool) -> None:
    diameter = 1000.0 if is_large else 120.0
    settings = ReceiverSettings('rolling', row_time, 6e-5, lamps=LampSettings(diameter_max=diameter))
    segments = segments_waveform(segments_from_packet(PACKET, 1), SegmentFormat())
    dark = longest_dark(segments if is_large else rs_fsk_waveform([PACKET], 30.0))
    rows = row_timing(settings, ()).stripe_rows
    assert dark / row_time <= rows <= dark / row_time + 3.0


def test_slow_tones_and_the_setting_determine_the_band_height() -> None:
    settings = ReceiverSettings('rolling', 1e-5)
    assert row_timing(settings, [1000.0, 4000.0]).stripe_rows == pytest.approx(51.0)
    told = ReceiverSettings('rolling', 1e-5, lamps=LampSettings(stripe_rows=7.0))
    assert row_timing(told, [1000.0, 4000.0]).stripe_rows == 7.0
