import math
from dataclasses import replace

import numpy as np
import pytest

from shirube_core.geometry import matrix_from_rpy
from vlc_beacon.core.survey.beacon_survey import LampBearings, NotSurveyed, SurveyedLamp, survey_lamp

LAMP = np.array([1.8, 0.4, 2.5])
TILT_SIGMA = 0.001


def slow_noise(rng, count):
    """Return noise of standard deviation 1 that is forgotten in 0.4 s, shape (count, 2)."""
    noise, inliers = rng.normal(size=(count, 2)), math.exp(-0.1 / 0.4)
    for k in range(1, count):
        noise[k] = inliers * noise[k - 1] + math.sqrt(1.0 - inliers**2) * noise[k]
    return noise


def bearings_of(rng, seconds=30.0, noise=2e-4, sway=0.0, bias=0.0, length=3.0, lamp=LAMP):
    """Return bearings of a lamp from a drive past it whose poses do not know how the body sways."""
    stamps = np.arange(0.0, seconds, 0.1)
    along = np.linspace(-0.5, 0.5, len(stamps)) * length
    positions = np.column_stack([lamp[0] + along, lamp[1] - 0.3 + 0.2 * np.sin(2.0 * along), 0.0 * along])
    yaws = 0.4 * np.cos(2.0 * along)
    tilts = sway * slow_noise(rng, len(stamps)) + bias * rng.normal(size=2)
    rotations = [matrix_from_rpy((0.0, 0.0, yaw + 0.5 * math.pi)) for yaw in yaws]
    rays = []
    for tilt, position, yaw in zip(tilts, positions, yaws, strict=True):
        true = matrix_from_rpy((0.0, 0.0, yaw)) @ matrix_from_rpy((*tilt, 0.5 * math.pi))
        point = true.T @ (lamp - position)
        rays.append(point[:2] / point[2] + noise * rng.normal(size=2))
    return LampBearings(stamps, positions, np.array(rotations), np.array(rays), np.full(len(stamps), noise))


def test_exact_bearings_give_the_exact_place():
    lamp = survey_lamp(bearings_of(np.random.default_rng(0), noise=1e-9), 0.0)
    assert lamp.xyz == pytest.approx(LAMP, abs=1e-6)
    assert lamp.observations == 300


@pytest.mark.parametrize(('sway', 'bias'), [(0.0, 0.0), (0.004, 0.0), (0.0, TILT_SIGMA)])
@pytest.mark.newest_set_only
def test_errors_are_as_large_as_is_stated(sway, bias):
    """Whether each bearing errs by itself, many together, or all."""
    scores, tilt = [], TILT_SIGMA if bias else 0.0
    for seed in range(40):
        lamp = survey_lamp(bearings_of(np.random.default_rng(seed), sway=sway, bias=bias), tilt)
        scores.append((np.array(lamp.xyz) - LAMP) / lamp.sigma)
    spread = np.sqrt(np.mean(np.square(scores), axis=0))
    assert (spread < 1.6).all()
    assert spread.max() > 0.3


def test_bearings_of_another_lamp_do_no_harm():
    rng = np.random.default_rng(3)
    bearings = bearings_of(rng)
    strange = rng.random(len(bearings)) < 0.1
    rays = bearings.rays + np.where(strange[:, None], 0.5, 0.0)
    lamp = survey_lamp(replace(bearings, rays=rays), 0.0)
    assert isinstance(lamp, SurveyedLamp)
    assert lamp.xyz == pytest.approx(LAMP, abs=0.001)
    assert lamp.observations == np.count_nonzero(~strange)


def test_undetermined_lamps_are_not_surveyed():
    for drive, advice in (({'seconds': 2.0}, 'drive on longer'), ({'length': 0.01}, 'drive past')):
        lamp = survey_lamp(bearings_of(np.random.default_rng(4), **drive), 0.0)
        assert isinstance(lamp, NotSurveyed)
        assert advice in lamp.reason
