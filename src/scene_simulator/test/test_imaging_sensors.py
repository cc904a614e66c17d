"""Grey levels and their noise against the counting of electrons."""

import numpy as np
import pytest

from scene_simulator.imaging.sensors import GainSensor

WIDE = (256, 300)


def grey(sensor: GainSensor, light: float, seed: int | None = None) -> np.ndarray:
    picture = np.full(WIDE, light, dtype=np.float32)
    return sensor.expose(picture, None if seed is None else np.random.default_rng(seed)).astype(float)


@pytest.mark.parametrize('gain', [1.0, 4.0])
@pytest.mark.parametrize('level', [0.0, 0.1, 0.5, 0.9])
def test_grey_levels_are_the_light_times_the_gain_above_black(gain: float, level: float) -> None:
    sensor = GainSensor(gain=gain, black_level=10.0 / 255.0)
    expected = min(10.0 + 255.0 * level, 255.0)
    assert np.abs(grey(sensor, level / gain) - expected).max() <= 0.5 + 1e-3


@pytest.mark.parametrize('sensor', [GainSensor(), GainSensor(gain=8.0), GainSensor(full_well=3000.0)])
@pytest.mark.parametrize('level', [0.2, 0.6])
def test_noise_is_that_of_the_electrons(sensor: GainSensor, level: float) -> None:
    electrons = level / sensor.gain * sensor.full_well
    deviation = np.sqrt(electrons + sensor.read_noise**2) * 255.0 * sensor.gain / sensor.full_well
    image = grey(sensor, level / sensor.gain, seed=3)
    # The last term is the rounding to whole levels.
    assert image.std() == pytest.approx(np.hypot(deviation, np.sqrt(1.0 / 12.0)), rel=0.02)
    assert image.mean() == pytest.approx(255.0 * (level + sensor.black_level), abs=6.0 * deviation / 277.0)


def test_rows_and_frames_have_noise_of_their_own() -> None:
    rng = np.random.default_rng(5)
    picture = np.full(WIDE, 0.5, dtype=np.float32)
    first, second = (GainSensor().expose(picture, rng).astype(float) for _ in range(2))
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(first[:-1].ravel(), first[1:].ravel())[0, 1]) < 0.02


def test_a_full_well_and_the_last_grey_level_saturate() -> None:
    assert (grey(GainSensor(), 5.0) == 255.0).all()
    assert (grey(GainSensor(gain=8.0), 0.5) == 255.0).all()
    # A full well is saturated: a lower gain does not recover the excess.
    assert (grey(GainSensor(gain=0.5), 1.0) == grey(GainSensor(gain=0.5), 3.0)).all()
    assert (grey(GainSensor(black_level=0.0), -1.0) == 0.0).all()
