"""CSV round trip of waveforms, and rejection of malformed CSV."""

from __future__ import annotations

import numpy as np
import pytest

from shirube_core.waveform import LightWaveformError, waveform_from_csv, waveform_from_steps, waveform_to_csv


@pytest.mark.parametrize('parts', [1, 2])
def test_the_same_numbers_come_back(parts: int) -> None:
    rng = np.random.default_rng(parts)
    waveform = waveform_from_steps(rng.uniform(1e-4, 1e-3, 200), rng.random((200, parts)))
    again = waveform_from_csv(waveform_to_csv(waveform))
    np.testing.assert_array_equal(again.times, waveform.times)
    np.testing.assert_array_equal(again.levels, waveform.levels)
    assert again.period == waveform.period


def test_csv_holds_one_period() -> None:
    text = waveform_to_csv(waveform_from_steps([0.25, 0.5], [[1.0, 0.0], [0.0, 0.5]]))
    assert text == 't,level_a,level_b\n0.0,1,0\n0.25,0,0.5\n0.75,1,0\n'


@pytest.mark.parametrize(
    ('text', 'complaint'),
    [
        ('', 'first line'),
        ('x,y\n0,1\n1,1\n', 'first line'),
        ('t,level\n0,1\n', 'no period'),
        ('t,level\n0,1\nlater,0\n1,1\n', 'line 3'),
        ('t,level_a,level_b\n0,1\n1,1\n', 'line 2'),
        ('t,level\n0,1\nnan,0\n', 'line 3'),
        ('t,level\n0,1.5\n1,1\n', 'outside 0 to 1'),
        ('t,level\n0,1\n0.5,0\n0.5,1\n', 'rise'),
    ],
)
def test_malformed_csv_is_rejected(text: str, complaint: str) -> None:
    with pytest.raises(LightWaveformError, match=complaint):
        waveform_from_csv(text)
