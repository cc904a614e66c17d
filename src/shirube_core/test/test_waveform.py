"""Properties of the integral, comparison with a sampled reference, and the CSV form."""

import numpy as np
import pytest

from shirube_core.waveform import LightWaveformError, Waveform, waveform_from_csv, waveform_from_steps, waveform_to_csv

UNEVEN = waveform_from_steps([0.7e-3, 0.2e-3, 1.1e-3], [[1.0, 0.0], [0.25, 1.0], [0.0, 0.5]])


@pytest.mark.parametrize('longest', [0.1e-3, 2e-3, 0.5])
def test_means_agree_with_fine_sampling(longest: float) -> None:
    rng, samples = np.random.default_rng(4), 20_000
    starts = rng.uniform(-3.0, 3.0, 40)
    stops = starts + rng.uniform(0.0, longest, 40)
    instants = starts[:, None] + (np.arange(samples) + 0.5) / samples * (stops - starts)[:, None]
    sampled = UNEVEN.levels_at(instants).mean(axis=1)
    np.testing.assert_allclose(UNEVEN.mean_levels(starts, stops), sampled, atol=1e-3)


def test_levels_hold_until_the_next_time_and_repeat() -> None:
    times = np.array([0.0, 0.69e-3, 0.71e-3, 0.95e-3])
    expected = [[1.0, 0.0], [1.0, 0.0], [0.25, 1.0], [0.0, 0.5]]
    for turns in (-3, 0, 5):
        np.testing.assert_array_equal(UNEVEN.levels_at(times + 1e-9 + turns * UNEVEN.period), expected)


def test_mean_of_a_window_is_that_of_its_parts() -> None:
    cuts = np.sort(np.random.default_rng(1).uniform(0.0, 0.02, 30))
    pieces = UNEVEN.mean_levels(cuts[:-1], cuts[1:]) * np.diff(cuts)[:, None]
    whole = UNEVEN.mean_levels(cuts[0], cuts[-1]) * (cuts[-1] - cuts[0])
    np.testing.assert_allclose(pieces.sum(axis=0), whole, rtol=1e-12)


def test_periods_that_are_added_up_hold_the_mean_of_all() -> None:
    for period in np.random.default_rng(1).uniform(1e-4, 1e-2, 200):
        blink = waveform_from_steps([0.3 * period, 0.7 * period], [1.0, 0.0])
        # A sum of periods lies a rounding before or after the border of a period.
        stops = np.cumsum(np.full(200, period))
        np.testing.assert_allclose(blink.mean_levels(np.zeros(200), stops)[:, 0], 0.3, atol=1e-9)


def test_a_window_without_length_is_an_instant() -> None:
    instants = np.linspace(-0.004, 0.004, 33) + 1e-6
    np.testing.assert_array_equal(UNEVEN.mean_levels(instants, instants), UNEVEN.levels_at(instants))


def test_windows_years_away_lose_no_light() -> None:
    far = 1e6 * UNEVEN.period
    near = UNEVEN.mean_levels(0.1e-3, 1.2e-3)
    np.testing.assert_allclose(UNEVEN.mean_levels(far + 0.1e-3, far + 1.2e-3), near, atol=1e-5)


def test_equal_neighbours_join_and_play_the_same() -> None:
    joined = waveform_from_steps([1e-3, 2e-3, 1e-3], [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(joined.times, [0.0, 3e-3])
    np.testing.assert_array_equal(joined.levels, [[1.0], [0.0]])
    assert joined.period == pytest.approx(4e-3)


@pytest.mark.parametrize(
    ('times', 'levels', 'period'),
    [
        ([0.0, 1.0], [[1.0]], 2.0),
        ([0.0], [[1.0, 0.0, 1.0]], 2.0),
        ([0.0], [1.0], 2.0),
        ([0.5], [[1.0]], 2.0),
        ([0.0, 0.0], [[1.0], [0.0]], 2.0),
        ([0.0, 2.0], [[1.0], [0.0]], 2.0),
        ([0.0], [[1.0]], float('inf')),
        ([0.0, float('nan')], [[1.0], [0.0]], 2.0),
        ([0.0], [[1.1]], 2.0),
        ([0.0], [[float('nan')]], 2.0),
        ([], np.empty((0, 1)), 2.0),
    ],
)
def test_invalid_waveforms_are_rejected(times: list[float], levels: object, period: float) -> None:
    with pytest.raises(LightWaveformError, match='waveform'):
        Waveform(np.array(times), np.array(levels), period)


@pytest.mark.parametrize(
    ('durations', 'levels'),
    [([], []), ([1.0], [1.0, 0.0]), ([1.0, 0.0], [1.0, 0.0]), ([1.0], [2.0]), ([[1.0]], [1.0]), ([1.0], 1.0)],
)
def test_invalid_steps_are_rejected(durations: object, levels: object) -> None:
    with pytest.raises(LightWaveformError, match=r'waveform|steps'):
        waveform_from_steps(durations, levels)


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
