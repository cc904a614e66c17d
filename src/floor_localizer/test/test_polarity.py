import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph, scattered_centres

from floor_localizer.core.dot_extraction.binarisation import choose_polarity

CENTRES = scattered_centres(20)
COVERAGE = disc_coverage(CENTRES, 7.0)


def chosen(image):
    return choose_polarity(image.reshape(*image.shape[:2], -1), 25.0)


@pytest.mark.parametrize('noise', [0.0, 2.0])
def test_dark_and_light_dots_are_distinguished(noise):
    light = np.linspace(0.5, 1.2, 160)[None, :]
    assert chosen(photograph(COVERAGE, 160.0, 40.0, light, noise)) == 'dark'
    assert chosen(photograph(COVERAGE, 60.0, 180.0, light, noise)) == 'light'


def test_neither_a_few_reflections_nor_lamps_mirrored_by_the_floor_change_anything():
    image = photograph(COVERAGE, noise=1.0)
    image[disc_coverage([[60.0, 8.0], [8.0, 60.0]], 9.0) > 0.5] = 255
    assert chosen(image) == 'dark'
    v, u = np.mgrid[:160, :160]
    lamps = sum(150.0 * np.exp(-0.5 * (np.hypot(u - x, v - 80.0) / 6.0) ** 2) for x in (30.0, 130.0))
    image = np.minimum(photograph(COVERAGE, 70.0, 15.0, noise=1.0) + lamps, 255).astype(np.uint8)
    assert chosen(image) == 'dark'


def test_both_kinds_or_colours_alone_make_any_and_black_dots_in_colour_are_dark():
    half = disc_coverage(CENTRES[::2], 7.0)
    both = np.rint(110.0 - 80.0 * half + 90.0 * (COVERAGE - half)).clip(0, 255).astype(np.uint8)
    assert chosen(both) == 'any'
    assert chosen(photograph(COVERAGE, (110.0, 110.0, 110.0), (60.0, 115.0, 155.0))) == 'any'
    assert chosen(photograph(COVERAGE, (130.0, 160.0, 180.0), (20.0, 20.0, 20.0))) == 'dark'


@pytest.mark.parametrize('beyond', [0.15, 0.5, 2.0])
@pytest.mark.parametrize('angle', [0.0, 0.7, 2.4, 4.0])
def test_the_edge_of_a_mat_or_a_shadow_changes_nothing(beyond, angle):
    v, u = np.mgrid[:160, :160] - 79.5
    light = np.where(np.cos(angle) * u + np.sin(angle) * v > 5.0, beyond, 1.0)
    covered = COVERAGE * (light == 1.0)
    assert chosen(photograph(covered, 110.0, 30.0, light, noise=1.0)) == 'dark'
    assert chosen(photograph(covered, 50.0, 110.0, light, noise=1.0)) == 'light'
