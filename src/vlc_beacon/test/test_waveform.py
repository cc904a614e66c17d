import numpy as np
import pytest

from vlc_beacon.core.light_code.waveform import waveform_of_steps


def random_waveform(seed: int):
    rng = np.random.default_rng(seed)
    return waveform_of_steps(rng.uniform(0.01, 0.2, 30), rng.integers(0, 2, (30, 2)))


def test_exposure_is_the_mean_of_many_looks() -> None:
    waveform = random_waveform(1)
    start, exposure = 0.123, 0.4
    looks = start + (np.arange(200_000) + 0.5) / 200_000 * exposure
    index = np.searchsorted(waveform.times, looks % waveform.period, side='right') - 1
    assert waveform.exposed(start, exposure) == pytest.approx(waveform.levels[index].mean(axis=0), abs=1e-4)


def test_it_repeats_before_and_after_its_period() -> None:
    waveform = random_waveform(2)
    times = np.linspace(-3.0, 3.0, 101)
    later = waveform.exposed(times + 5 * waveform.period, 0.05)
    assert later == pytest.approx(waveform.exposed(times, 0.05), abs=1e-9)


def test_exposures_add_up() -> None:
    waveform = random_waveform(3)
    halves = waveform.exposed(0.2, 0.3) * 0.3 + waveform.exposed(0.5, 0.7) * 0.7
    assert halves == pytest.approx(waveform.exposed(0.2, 1.0))


def test_equal_neighbours_become_one() -> None:
    waveform = waveform_of_steps([1.0, 2.0, 3.0, 4.0], [1, 1, 0, 0])
    assert waveform.times.tolist() == [0.0, 3.0]
    assert waveform.levels.tolist() == [[1.0], [0.0]]
    assert waveform.period == 10.0
