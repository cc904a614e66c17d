import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph, scattered_centres

from floor_localizer.core.dot_extraction.binarisation import smooth_background, upsample

CENTRES = scattered_centres(1, 16)
LIGHT = np.linspace(0.6, 1.3, 160)[None, :] * np.ones((160, 1))


def background_of(image, polarity, largest):
    return upsample(smooth_background(image, polarity, largest), image.shape[1], image.shape[0])


@pytest.mark.parametrize(
    ('polarity', 'dot'), [('dark', 20.0), ('light', 250.0), ('any', 20.0), ('any', 250.0)]
)
@pytest.mark.parametrize('largest', [25.0, 40.0])
def test_dots_leave_no_trace_in_the_background(polarity, dot, largest):
    image = photograph(disc_coverage(CENTRES, 9.0), floor=120.0, dot=dot, light=LIGHT)
    background = background_of(image[..., None], polarity, largest)
    np.testing.assert_allclose(background[8:-8, 8:-8, 0], (120.0 * LIGHT)[8:-8, 8:-8], rtol=0.05)


def test_the_edge_of_a_shadow_stays_where_it_is():
    light = np.where(np.add(*np.mgrid[:160, :160]) > 150, 0.4, 1.0)
    image = photograph(disc_coverage(CENTRES, 7.0), light=light)
    background = background_of(image[..., None], 'dark', 25.0)[..., 0]
    assert np.mean(np.abs(background / (160.0 * light) - 1.0) > 0.02) < 0.001


@pytest.mark.parametrize('polarity', ['dark', 'light', 'any'])
def test_the_gradient_up_to_the_border_and_the_noise_leave_no_bias(polarity):
    image = photograph(np.zeros((160, 160)), light=LIGHT, noise=3.0)
    background = background_of(image[..., None], polarity, 25.0)[..., 0]
    ratio = background / (160.0 * LIGHT)
    assert abs(np.median(ratio) - 1.0) < 0.02
    assert np.abs(np.median(ratio[:, :5]) - 1.0) < 0.06
    assert np.abs(np.median(ratio[:, -5:]) - 1.0) < 0.06


def test_black_stays_above_zero():
    assert smooth_background(np.zeros((50, 70, 3), np.uint8), 'any', 25.0).min() >= 1.0
