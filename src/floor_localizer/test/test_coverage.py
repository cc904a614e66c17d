import numpy as np
import pytest

from floor_localizer.core.dot_extraction.coverage import (
    contrast_along,
    contrast_direction,
    dot_level,
    floor_level,
)

RNG = np.random.default_rng(0)


@pytest.mark.parametrize('count', [3, 24, 25, 90, 400])
def test_the_level_of_a_noisy_ring_is_its_mean(count):
    ring = RNG.normal(0.03, 0.01, count)
    assert floor_level(ring) == pytest.approx(0.03, abs=4.0 * 0.01 / np.sqrt(count))


def test_outliers_on_a_ring_do_not_change_its_level():
    ring = RNG.normal(0.0, 0.01, 90)
    ring[10:25] = 0.8
    assert abs(floor_level(ring)) < 0.006


def test_a_blob_without_ring_keeps_the_background():
    assert floor_level(np.empty(0)) == 0.0


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
