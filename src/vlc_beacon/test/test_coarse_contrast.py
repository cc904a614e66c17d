import numpy as np
import pytest
from lamp_pictures import blinking_rows, draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.coarse_contrast import CELL, coarse_contrast, noise_sigma


def test_a_ceiling_that_is_unevenly_lit_has_no_contrast():
    contrast, _ = coarse_contrast(photograph(room(level=30.0, gradient=40.0)), 60.0, 0.0)
    assert contrast[:, 8:-8].max() <= 3


def test_contrast_of_a_lamp_is_its_own_brightness():
    picture = draw_lamp(room(level=30.0, gradient=20.0), (200.0, 150.0), 12.0, 100.0)
    contrast, background = coarse_contrast(photograph(picture), 60.0, 0.0)
    assert contrast[150 // CELL, 200 // CELL] == pytest.approx(100.0, abs=3.0)
    assert background[150 // CELL, 200 // CELL] == pytest.approx(40.0, abs=3.0)


def test_what_is_larger_than_a_lamp_is_background():
    picture = room()
    picture[:, 100:330] += 150.0
    contrast, _ = coarse_contrast(photograph(picture), 40.0, 0.0)
    assert contrast[:, 40:65].max() <= 2


def test_stripes_are_closed():
    rows = blinking_rows(2000.0, 2e-5, 5e-5)
    picture = draw_lamp(room(), (200.0, 150.0), 60.0, 150.0, rows=rows)
    contrast, _ = coarse_contrast(photograph(picture), 200.0, 16.0)
    assert contrast[140 // CELL : 160 // CELL, 200 // CELL].min() > 60


@pytest.mark.parametrize('sigma', [0.8, 2.0, 6.0])
def test_noise_is_measured_though_the_ceiling_is_uneven(sigma):
    picture = draw_lamp(room(600, 600, 60.0, 40.0), (200.0, 150.0), 30.0, 100.0)
    image = photograph(picture, sigma, np.random.default_rng(1))
    assert noise_sigma(image) == pytest.approx(np.hypot(sigma, 0.29), rel=0.12)


def test_an_image_without_noise_has_that_of_rounding():
    assert noise_sigma(np.zeros((300, 400), np.uint8)) == pytest.approx(0.3)
