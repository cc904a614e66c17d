import numpy as np
import pytest
from drawn_floor import FLOOR, disc_coverage, line_coverage, nearest, offsets, photograph, scattered_centres

from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.errors import DotImageError
from floor_localizer.core.settings import DotDetectorSettings
from shirube_core.settings import SettingsError

DETECTOR = DotDetector()


def detector(**settings):
    return DotDetector(DotDetectorSettings(**settings))


def errors(dots, centres):
    assert len(dots) == len(centres)
    return np.abs(offsets(dots.pixels, centres)).max()


@pytest.mark.parametrize('seed', range(3))
def test_finds_all_discs_where_they_are(seed):
    centres = scattered_centres(seed)
    diameters = np.random.default_rng(seed).uniform(5.0, 8.0, len(centres))
    dots = DETECTOR.detect(photograph(disc_coverage(centres, diameters), noise=1.5))
    assert errors(dots, centres) < 0.08
    order = nearest(dots.pixels, centres)
    np.testing.assert_allclose(dots.diameters[order], diameters, rtol=0.05)


def test_a_shift_by_part_of_a_pixel_moves_all_centroids_by_it():
    centres = scattered_centres(5)
    before = DETECTOR.detect(photograph(disc_coverage(centres, 6.4)))
    for shift in (np.array([0.37, -0.21]), np.array([-0.5, 0.5]), np.array([1.25, 0.8])):
        after = DETECTOR.detect(photograph(disc_coverage(centres + shift, 6.4)))
        moved = offsets(after.pixels, before.pixels)
        np.testing.assert_allclose(moved, np.broadcast_to(shift, moved.shape), atol=0.04)


def test_the_negative_has_its_dots_in_the_same_places():
    centres = scattered_centres(6)
    image = photograph(disc_coverage(centres, 7.0), noise=1.0)
    dots, negative = DETECTOR.detect(image), DETECTOR.detect(255 - image)
    assert len(dots) == len(negative) == len(centres)
    assert np.abs(offsets(negative.pixels, dots.pixels)).max() < 0.05


@pytest.mark.parametrize(('gain', 'offset'), [(0.5, 0.0), (1.4, 0.0), (1.0, 25.0), (0.7, 10.0)])
def test_brighter_or_darker_light_moves_nothing(gain, offset):
    coverage = disc_coverage(scattered_centres(7), 6.0)
    dots = DETECTOR.detect(photograph(coverage))
    changed = DETECTOR.detect(photograph(coverage, floor=gain * FLOOR + offset, dot=gain * 30.0 + offset))
    assert len(dots) == len(changed)
    assert np.abs(offsets(changed.pixels, dots.pixels)).max() < 0.03
    np.testing.assert_allclose(np.sort(changed.diameters), np.sort(dots.diameters), rtol=0.02)


def test_neither_a_strong_gradient_nor_motion_blur_moves_the_centres():
    centres = scattered_centres(8)
    light = np.linspace(0.35, 1.3, 160)[None, :] * np.linspace(1.1, 0.8, 160)[:, None]
    assert errors(DETECTOR.detect(photograph(disc_coverage(centres, 6.5), light=light)), centres) < 0.06
    centres = scattered_centres(11, 12, distance=30.0)
    steps = np.linspace(-0.5, 0.5, 21)[:, None] * np.array([7.0, 4.0])
    blurred = np.mean([disc_coverage(centres + step, 6.0) for step in steps], axis=0)
    assert errors(DETECTOR.detect(photograph(blurred, noise=0.7)), centres) < 0.2


@pytest.mark.parametrize('polarity', ['auto', 'dark', 'any'])
def test_the_edge_of_a_shadow_is_no_dot_and_hides_none_next_to_it(polarity):
    centres = scattered_centres(9, 12)
    v, u = np.mgrid[:160, :160]
    edge = (u - 80) * np.cos(0.4) + (v - 80) * np.sin(0.4)
    off_edge = np.abs((centres - 80) @ (np.cos(0.4), np.sin(0.4))) > 7.0
    light = 1.0 - 0.55 / (1.0 + np.exp(-edge))
    dots = detector(polarity=polarity).detect(photograph(disc_coverage(centres, 6.5), light=light, noise=1.0))
    assert len(dots) <= len(centres)
    assert np.abs(offsets(dots.pixels, centres[off_edge])).max() < 0.1


@pytest.mark.parametrize('polarity', ['auto', 'dark', 'light', 'any'])
@pytest.mark.parametrize('noise', [0.0, 1.0, 5.0])
def test_an_empty_floor_has_no_dots(polarity, noise):
    light = np.linspace(0.5, 1.3, 235)[None, :] * np.ones((235, 1))
    dots = detector(polarity=polarity).detect(photograph(np.zeros((235, 235)), light=light, noise=noise))
    assert dots.pixels.shape == (0, 2)
    for level in (0, 128, 255):
        assert len(detector(polarity=polarity).detect(np.full((64, 48), level, np.uint8))) == 0


def test_hairs_and_specks_are_no_dots_even_across_a_dot():
    centres = scattered_centres(10)
    coverage = disc_coverage(centres, 7.0)
    free = np.array([[40.0, 3.0], [3.0, 90.0]])
    hairs = [
        line_coverage(tuple(centres[0] - (20, 12)), tuple(centres[0] + (20, 12)), 1.0),
        line_coverage((2.0, 20.0), (50.0, 2.0), 1.2),
        line_coverage((150.0, 20.0), (120.0, 155.0), 0.8),
        disc_coverage(free, 1.6),
    ]
    dots = DETECTOR.detect(photograph(np.maximum.reduce([coverage, *hairs]), noise=1.0))
    assert len(dots) == len(centres)
    assert np.abs(offsets(dots.pixels, centres)).max() < 0.5


@pytest.mark.parametrize('gap', [-0.5, 0.0, 1.0])
@pytest.mark.parametrize('turn', [0.0, 0.6, 1.2])
def test_two_touching_discs_are_two_dots(gap, turn):
    middle, apart = np.array([80.3, 75.6]), np.array([np.cos(turn), np.sin(turn)]) * (7.0 + gap) / 2
    pair = [middle - apart, middle + apart]
    others = np.array([[25.0, 30.0], [130.0, 28.0], [30.0, 130.0], [125.0, 130.0]])
    centres = np.array([*pair, *others])
    dots = DETECTOR.detect(photograph(disc_coverage(centres, 7.0), noise=1.0))
    assert errors(dots, centres) < 0.35
    of_pair = np.hypot(*(dots.pixels - middle).T) < 6.0
    assert dots.sigmas[of_pair].min() > 3.0 * dots.sigmas[~of_pair].max()


def test_a_dot_that_the_border_cuts_is_left_out():
    whole = np.array([[30.0, 40.0], [80.0, 80.0], [120.0, 60.0], [60.0, 130.0]])
    cut = np.array([[1.0, 100.0], [100.0, 157.5], [158.8, 20.0], [60.0, -1.0]])
    dots = DETECTOR.detect(photograph(disc_coverage(np.vstack([whole, cut]), 7.0)))
    assert errors(dots, whole) < 0.05


def test_a_reflection_is_no_light_dot():
    centres = scattered_centres(12, 12)
    image = photograph(disc_coverage(centres, 7.0), floor=35.0, dot=170.0, noise=1.0)
    glare = disc_coverage([[8.0, 80.0]], 7.0)
    image = np.maximum(image, np.rint(255 * glare).astype(np.uint8))
    assert errors(detector(polarity='light').detect(image), centres) < 0.06


@pytest.mark.parametrize('polarity', ['auto', 'any'])
def test_chips_of_the_same_brightness_are_found_by_colour(polarity):
    centres = scattered_centres(13)
    image = photograph(disc_coverage(centres, 7.0), (120.0, 120.0, 120.0), (60.0, 125.0, 170.0), noise=1.0)
    assert errors(detector(polarity=polarity).detect(image), centres) < 0.06


def test_dark_and_light_chips_on_grey_are_found_together():
    centres = scattered_centres(14)
    dark, light = disc_coverage(centres[::2], 7.0), disc_coverage(centres[1::2], 7.0)
    image = np.rint(110.0 - 80.0 * dark + 100.0 * light).astype(np.uint8)
    assert errors(DETECTOR.detect(image), centres) < 0.06


@pytest.mark.parametrize(('noise', 'floor', 'dot'), [(1.5, 160.0, 30.0), (5.0, 160.0, 30.0), (2.0, 40.0, 150.0)])
def test_errors_are_as_large_as_their_sigmas_say(noise, floor, dot):
    normalised = []
    for seed in range(25):
        centres = scattered_centres(seed, 12)
        dots = DETECTOR.detect(photograph(disc_coverage(centres, 6.0), floor, dot, noise=noise, seed=seed))
        assert len(dots) == len(centres)
        order = nearest(dots.pixels, centres)
        normalised.append((dots.pixels[order] - centres) / dots.sigmas[order, None])
    assert 0.65 < np.sqrt(np.mean(np.square(normalised))) < 1.35


@pytest.mark.newest_set_only
def test_a_large_image_is_free_of_its_larger_hairs():
    size = (1024, 1280)
    centres = scattered_centres(16, 20, size, distance=120.0, margin=60.0)
    hair = line_coverage((100.0, 30.0), (1100.0, 990.0), 3.0, size)
    away = np.abs((centres - (100.0, 30.0)) @ (0.6925, -0.7214)) > 40.0
    dots = DETECTOR.detect(photograph(np.maximum(disc_coverage(centres, 36.0, size), hair), noise=1.5))
    assert len(dots) == len(centres)
    assert np.abs(offsets(dots.pixels, centres[away])).max() < 0.05


def test_the_image_stays_as_it_was_may_be_a_view_and_a_grey_colour_image():
    image = photograph(disc_coverage(scattered_centres(17), 6.0), noise=1.0)
    wide = np.zeros((160, 200), np.uint8)
    wide[:, 20:180] = image
    for other in (wide[:, 20:180], np.repeat(image[..., None], 3, axis=2)):
        np.testing.assert_array_equal(DETECTOR.detect(other).pixels, DETECTOR.detect(image).pixels)
    np.testing.assert_array_equal(wide[:, 20:180], image)


@pytest.mark.parametrize(('image', 'expected'), [
    (np.zeros((64, 64), np.uint16), 'uint16'), (np.zeros((64, 64)), 'float64'), ([[1, 2], [3, 4]], 'list'),
    (np.zeros((64, 64, 4), np.uint8), '(64, 64, 4)'), (np.zeros(64, np.uint8), '(64,)'),
    (np.zeros((20, 64), np.uint8), '64 x 20'), (np.zeros((0, 0), np.uint8), '0 x 0'),
])  # fmt: skip
def test_what_is_no_image_is_refused_in_one_line(image, expected):
    with pytest.raises(DotImageError) as refusal:
        DETECTOR.detect(image)
    assert expected in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_settings_that_contradict_each_other_are_refused():
    with pytest.raises(SettingsError, match='maximum_diameter is 4 px'):
        detector(minimum_diameter=5.0, maximum_diameter=4.0)
    with pytest.raises(SettingsError, match='polarity'):
        detector(polarity='blue')


def test_the_largest_diameter_follows_the_image_unless_it_is_set():
    assert DotDetectorSettings().largest_diameter(235, 235) == 25.0
    assert DotDetectorSettings().largest_diameter(1024, 1280) == 64.0
    assert DotDetectorSettings(maximum_diameter=12.0).largest_diameter(1280, 1024) == 12.0
