"""Readings of the tilt against the truth."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.tilt_sensor import TiltErrors, simulate_tilt

TIMES = np.arange(0.0, 40.0, 0.01).tolist()


def swaying(time: float) -> tuple[float, float]:
    return 0.02 * np.sin(time), -0.01 * np.cos(0.7 * time)


def errors_of(errors: TiltErrors, seed: int) -> np.ndarray:
    readings = simulate_tilt(swaying, TIMES, errors, np.random.default_rng(seed))
    return np.array([(r.roll, r.pitch) for r in readings]) - [swaying(time) for time in TIMES]


def test_an_ideal_unit_measures_the_true_tilt() -> None:
    np.testing.assert_allclose(errors_of(TiltErrors(0.0, 0.0), 1), 0.0, atol=1e-15)


@pytest.mark.newest_set_only
def test_noise_is_new_each_time_and_the_bias_stays() -> None:
    errors = errors_of(TiltErrors(bias=0.01, noise=0.002), 1)
    np.testing.assert_allclose(errors.std(axis=0), 0.002, rtol=0.05)
    assert abs(np.corrcoef(errors[:-1, 0], errors[1:, 0])[0, 1]) < 0.05
    biases = np.array([errors_of(TiltErrors(0.01, 0.002), seed).mean(axis=0) for seed in range(60)])
    assert biases.std() == pytest.approx(0.01, rel=0.25)
