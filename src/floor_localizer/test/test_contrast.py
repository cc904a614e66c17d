import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph, scattered_centres

from floor_localizer.core.dot_extraction.centroids import noise_at
from floor_localizer.core.dot_extraction.contrast import (
    contrast_along,
    contrast_direction,
    dot_level,
    ring_contrast_level,
)

RNG = np.random.default_rng(0)


@pytest.mark.parametrize('count', [3, 24, 25, 90, 400])
def test_the_level_of_a_noisy_ring_is_its_mean(count):
    ring = RNG.normal(0.03, 0.01, count)
    assert ring_contrast_level(ring) == pytest.approx(0.03, abs=4.0 * 0.01 / np.sqrt(count))


def test_outliers_on_a_ring_do_not_change_its_level_and_without_ring_the_background_stays():
    ring = RNG.normal(0.0, 0.01, 90)
    ring[10:25] = 0.8
    assert abs(ring_contrast_level(ring)) < 0.006
    assert ring_contrast_level(np.empty(0)) == 0.0


def test_the_level_of_a_dot_is_the_mean_of_its_upper_quarter():
    inside = RNG.permutation(np.linspace(0.0, 0.9, 2001))
    assert dot_level(inside) == pytest.approx(0.7875, abs=0.01)
    assert dot_level(np.array([-0.1, 0.0])) == 0.0


def test_contrast_is_measured_along_the_direction_of_the_colour():
    image = np.array([[[60, 120, 180], [90, 120, 150], [120, 120, 120]]], np.uint8)
    background = np.full((1, 3, 3), 120.0, np.float32)
    places = np.array([[0, 0], [0, 1], [0, 2]])
    direction = contrast_direction(image, background, places[:1])
    np.testing.assert_allclose(direction, np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0))
    expected = np.array([1.0, 0.5, 0.0]) / np.sqrt(2.0)
    np.testing.assert_allclose(contrast_along(image, background, places, direction), expected)


@pytest.mark.parametrize('noise', [0.7, 1.5, 4.0, 10.0])
@pytest.mark.parametrize('channels', [1, 3])
def test_measures_the_noise_under_dots_and_gradient(noise, channels):
    light = np.linspace(0.6, 1.3, 160)[None, :]
    coverage = disc_coverage(scattered_centres(4), 7.0)
    planes = [photograph(coverage, light=light, noise=noise, seed=c) for c in range(channels)]
    pixels = np.array([[u, v] for u in (0, 60, 159) for v in (0, 60, 159)])
    np.testing.assert_allclose(noise_at(np.stack(planes, axis=2), pixels).mean(), np.hypot(noise, 12.0**-0.5), rtol=0.2)


def test_noise_is_measured_locally_and_is_never_less_than_rounding():
    image = photograph(np.zeros((160, 160)), noise=1.0)
    image[96:, 96:] = photograph(np.zeros((64, 64)), noise=6.0, seed=1)
    quiet, noisy = noise_at(image[..., None], np.array([[10, 10], [150, 150]]))
    assert noisy > 4.0 * quiet
    assert noise_at(np.full((40, 40, 1), 7, np.uint8), np.array([[20, 20]]))[0] == pytest.approx(12.0**-0.5)
