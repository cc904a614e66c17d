import cv2
import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph, scattered_centres

from floor_localizer.core.dot_extraction.binarisation import (
    SIGNS,
    binarise,
    contrast_threshold,
    smooth_background,
    upsample,
)
from floor_localizer.core.dot_extraction.contrast import relative_contrast
from floor_localizer.core.settings import DotDetectorSettings

CENTRES = scattered_centres(1, 16)
LIGHT = np.linspace(0.6, 1.3, 160)[None, :] * np.ones((160, 1))


def background_of(image, polarity, largest):
    return upsample(smooth_background(image, polarity, largest), image.shape[1], image.shape[0])


@pytest.mark.parametrize(('polarity', 'dot'), [('dark', 20), ('light', 250), ('any', 20), ('any', 250)])
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
    for border in (ratio[:, :5], ratio[:, -5:]):
        assert abs(np.median(border) - 1.0) < 0.06
    # Black stays above zero.
    assert smooth_background(np.zeros((50, 70, 3), np.uint8), polarity, 25.0).min() >= 1.0


@pytest.mark.parametrize('polarity', ['dark', 'light'])
def test_a_slight_gradient_makes_no_plateaus(polarity):
    light = np.linspace(0.9, 1.1, 160)[None, :] * np.ones((160, 1))
    image = photograph(np.zeros((160, 160)), light=light, noise=1.0)
    ratio = background_of(image[..., None], polarity, 25.0)[..., 0] / (160.0 * light)
    assert np.std(ratio[20:-20, 20:-20]) < 0.002


SETTINGS = DotDetectorSettings()
BACKGROUND = np.full((160, 160, 1), 160.0, np.float32)


def threshold_of(image, polarity='dark', settings=SETTINGS):
    return cv2.resize(contrast_threshold(image, BACKGROUND, polarity, settings), (160, 160))


def contrast_image(image, background, polarity):
    return relative_contrast(image, background, SIGNS[polarity])


def test_contrast_is_the_covered_fraction_times_the_darkness_of_light_its_opposite_of_any_its_size():
    coverage = disc_coverage([[80.0, 70.0]], 20.0)
    image = photograph(coverage)[..., None]
    contrast = contrast_image(image, BACKGROUND, 'dark')
    np.testing.assert_allclose(contrast, coverage * (160.0 - 30.0) / 160.0, atol=0.005)
    np.testing.assert_allclose(contrast_image(image, BACKGROUND, 'light'), -contrast)
    np.testing.assert_allclose(contrast_image(image, BACKGROUND, 'any'), np.abs(contrast))


@pytest.mark.parametrize('noise', [2.0, 6.0])
def test_without_dots_the_threshold_is_five_deviations_of_the_noise(noise):
    threshold = threshold_of(photograph(np.zeros((160, 160)), noise=noise)[..., None])
    np.testing.assert_allclose(np.median(threshold), 5.0 * noise / 160.0, rtol=0.2)


def test_with_dots_the_threshold_is_a_part_of_their_contrast_whatever_their_number():
    for count in (3, 14):
        image = photograph(disc_coverage(scattered_centres(2, count), 8.0), noise=1.0)[..., None]
        threshold = threshold_of(image)
        np.testing.assert_allclose(threshold, 0.3 * 130.0 / 160.0, rtol=0.1)


def test_the_threshold_is_higher_where_the_floor_is_rough():
    rough = np.arange(160) >= 80
    image = photograph(np.zeros((160, 160)), noise=1.0)
    image[:, rough] = photograph(np.zeros((160, 80)), noise=12.0, seed=1)
    threshold = threshold_of(image[..., None])
    assert threshold[:, 120:].min() > 3.0 * threshold[:, :30].max()


def test_a_giant_dark_patch_hardly_raises_and_pale_areas_do_not_lower_the_threshold_next_to_it():
    image = photograph(np.zeros((160, 160)), noise=1.0)
    plain = threshold_of(image[..., None]).max()
    image[40:110, 40:110] = 150
    assert threshold_of(image[..., None]).max() < 1.5 * plain
    image = photograph(disc_coverage(scattered_centres(2, 14), 8.0), noise=1.0)
    plain = threshold_of(image[..., None]).max()
    image[:, :14] = np.minimum(image[:, :14], 120)
    assert threshold_of(image[..., None]).max() > 0.9 * plain


@pytest.mark.parametrize('polarity', ['dark', 'light', 'any'])
def test_the_binary_image_is_the_contrast_above_the_threshold(polarity):
    image = photograph(disc_coverage(scattered_centres(3), 7.0), noise=20.0)[..., None]
    threshold = np.random.default_rng(0).uniform(0.05, 0.5, (160, 160)).astype(np.float32)
    expected = contrast_image(image, BACKGROUND, polarity) - threshold
    mask = binarise(image, BACKGROUND, polarity, threshold)
    clear = np.abs(expected) > 0.501 / 160.0
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(mask[clear] > 0, (expected > 0.0)[clear])
