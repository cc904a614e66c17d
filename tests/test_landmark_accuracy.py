"""The accuracy bound and scores of landmarks, against a second computation and normal deviates."""

import importlib
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scene_simulator.corridor.stereo_rig import RECTIFIED
from scene_simulator.imaging.sensors import GainSensor

pytestmark = pytest.mark.newest_set_only

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmarks'


@pytest.fixture(scope='module', autouse=True)
def benchmarks() -> Iterator[None]:
    """Lets the benchmarks be imported."""
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


@pytest.mark.parametrize('size', [12.0, 30.0])
def test_the_bound_of_an_outline_is_that_of_all_pixels(monkeypatch, size):
    """Two ways to it: sides that act independently, and derivatives of exact areas of the whole picture."""
    bound = importlib.import_module('_landmark_bound')
    pictures = importlib.import_module('_primitive_pictures')
    condition = pictures.Condition(size=size)
    picture = pictures.quadrilateral_picture(condition, 3)
    variance = condition.noise**2 + 1.0 / 12.0
    monkeypatch.setattr(bound, 'grey_variance', lambda levels, sensor: np.full(len(levels), variance))
    camera = replace(RECTIFIED, optics=replace(RECTIFIED.optics, blur=condition.blur))
    covariance = bound.outline_covariance(picture.image, picture.truth.reshape(4, 2), camera)
    assert np.mean(np.diag(covariance)) == pytest.approx(picture.bound, rel=0.1)


@pytest.mark.parametrize('light', [0.05, 0.2, 0.7])
def test_the_noise_of_grey_levels_is_that_of_the_sensor(light):
    bound = importlib.import_module('_landmark_bound')
    sensor = GainSensor(gain=0.97)
    image = sensor.expose(np.full((400, 400), light, np.float32), np.random.default_rng(1)).astype(float)
    assert bound.grey_variance(np.array([image.mean()]), sensor)[0] == pytest.approx(image.var(), rel=0.05)


def test_runs_of_white_cells_are_found():
    views = importlib.import_module('_landmark_views')
    assert views.white_runs([True, False, True, True, False]) == [(0, 1), (2, 4)]
    assert views.white_runs([False, False]) == []


def test_normal_errors_are_consistent_with_their_covariance():
    score = importlib.import_module('_landmark_score')
    rng = np.random.default_rng(2)
    root = np.array([[1e-3, 0.0, 0.0], [2e-3, 1e-3, 0.0], [1e-3, 0.0, 5e-4]])
    judged = [(root @ rng.normal(size=3), root @ root.T) for _ in range(4000)]
    nees, share = score.consistency(judged)
    assert nees == pytest.approx(1.0, abs=0.05)
    assert share == pytest.approx(0.95, abs=0.01)
    assert score.rms_ratios(judged) == pytest.approx((1.0, 1.0), abs=0.05)
    doubled = [(2.0 * error, covariance) for error, covariance in judged]
    assert score.rms_ratios(doubled) == pytest.approx((2.0, 2.0), abs=0.1)
