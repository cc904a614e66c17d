import cv2
import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.lamp_detector import CELL, LampDetector, coarse_contrast, find_candidates, noise_sigma
from vlc_beacon.core.settings import LampSettings
from vlc_beacon.core.vlc_beacon_error import LampImageError

PLACES = np.array([[60.0, 60.0], [200.0, 70.0], [330.0, 90.0], [90.0, 220.0], [280.0, 230.0]])
RADIUS = 8.25


def errors_over_sigmas(level, background, gradient, noise, pictures, rng, stains=None):
    """Return errors of centroids and the same over their sigmas, all lamps found."""
    detector, errors, normalised = LampDetector(), [], []
    for _ in range(pictures):
        picture = room(level=background, gradient=gradient)
        if stains is not None:
            stains(picture, rng)
        places = PLACES + rng.uniform(0.0, 1.0, PLACES.shape)
        for place in places:
            draw_lamp(picture, place, RADIUS, level)
        blobs = detector.detect(photograph(picture, noise, rng))
        distances = np.hypot(*(blobs.centroids[:, None] - places).transpose(2, 0, 1))
        nearest = distances.argmin(axis=0)
        assert (distances.min(axis=0) < 1.0).all()
        assert len(blobs) == len(places) or stains is not None
        errors.append(blobs.centroids[nearest] - places)
        normalised.append(errors[-1] / blobs.sigmas[nearest])
    return np.concatenate(errors), np.sqrt(np.mean(np.square(normalised)))


@pytest.mark.parametrize(
    ('level', 'background', 'gradient', 'noise', 'rms'),
    [
        (7.0, 3.0, 0.0, 1.0, 0.1),
        (7.0, 60.0, 15.0, 1.5, 0.16),
        (100.0, 60.0, 15.0, 2.0, 0.05),
        (500.0, 3.0, 0.0, 1.5, 0.05),
    ],
)
def test_centroid_errors_match_their_sigmas(level, background, gradient, noise, rms):
    rng = np.random.default_rng(1)
    errors, normalised = errors_over_sigmas(level, background, gradient, noise, 8, rng)
    assert np.sqrt(np.mean(errors**2)) < rms
    assert normalised < 1.25


def test_a_dim_lamps_centroid_is_near_the_cramer_rao_bound():
    # The bound for the place of a disc under white noise: sum of the squared derivatives by central differences.
    right, left = (draw_lamp(room(), (u, 60.4), RADIUS, 7.0) for u in (60.35, 60.25))
    bound = 1.0 / np.sqrt(np.sum(((right - left) / 0.1) ** 2))
    errors, _ = errors_over_sigmas(7.0, 3.0, 0.0, 1.0, 10, np.random.default_rng(2))
    assert 0.8 * bound < np.sqrt(np.mean(errors**2)) < 2.2 * bound


def stained_and_tiled(picture, rng):
    picture += 15.0 * cv2.GaussianBlur(rng.normal(size=picture.shape), (0, 0), 6.0)
    picture[20::97] -= 10.0
    picture[:, 15::97] -= 10.0


@pytest.mark.parametrize('level', [30.0, 120.0])
def test_a_stained_and_tiled_ceiling_is_allowed_for(level):
    rng = np.random.default_rng(5)
    _, normalised = errors_over_sigmas(level, 60.0, 15.0, 2.0, 12, rng, stained_and_tiled)
    assert normalised < 1.5


def test_lamps_move_with_the_picture():
    rng = np.random.default_rng(3)
    picture = draw_lamp(room(), (150.3, 140.6), RADIUS, 120.0)
    image = photograph(picture, 1.5, rng)
    here = LampDetector().detect(image).centroids[0]
    for shift in ((3, 0), (0, 5), (-7, 2)):
        there = LampDetector().detect(np.roll(image, shift, (1, 0))).centroids[0]
        assert there - here == pytest.approx(shift, abs=0.02)
    mirrored = LampDetector().detect(np.ascontiguousarray(image[:, ::-1])).centroids[0]
    assert mirrored[0] == pytest.approx(399.0 - here[0], abs=0.02)


def test_radius_and_brightness_are_those_of_the_lamp():
    blobs = LampDetector().detect(photograph(draw_lamp(room(level=20.0), (150.3, 140.6), 15.0, 120.0)))
    assert blobs.radii[0] == pytest.approx(15.0, abs=0.2)
    assert blobs.brightness[0] == pytest.approx(120.0, rel=0.05)
    assert blobs.backgrounds[0] == pytest.approx(20.0, abs=0.5)
    assert blobs.roundness[0] > 0.95


def tube_window_and_speck():
    picture = room(level=20.0)
    picture[100:106, 50:250] = 200.0
    picture[200:, 300:] = 220.0
    picture[50:52, 300:302] = 230.0
    return picture


@pytest.mark.parametrize(
    ('picture', 'noise', 'lamps'),
    [
        (tube_window_and_speck(), 0.0, 0),
        (draw_lamp(room(), (3.0, 100.0), RADIUS, 120.0), 0.0, 0),
        *((room(600, 800, 40.0), noise, 0) for noise in (1.0, 3.0, 10.0)),
        (draw_lamp(room(), (150.3, 140.6), RADIUS, 120.0, halves=(1.0, 0.0), angle=0.6), 0.0, 1),
    ],
    ids=['tube, window, speck', 'lamp at the border', *(f'noise {n}' for n in (1, 3, 10)), 'half a panel'],
)
def test_only_lamps_and_halves_of_them_are_found(picture, noise, lamps):
    image = photograph(picture, noise, np.random.default_rng(4))
    assert len(LampDetector().detect(image)) == lamps


@pytest.mark.parametrize(
    ('image', 'words'),
    [
        (np.zeros((100, 100), np.float32), 'type float32'),
        (np.zeros((100, 100, 3), np.uint8), '3 dimensions'),
        (np.zeros((10, 100), np.uint8), '100 x 10 pixels'),
    ],
)
def test_invalid_images_are_rejected(image, words):
    with pytest.raises(LampImageError, match=words):
        LampDetector().detect(image)


def test_a_ceiling_that_is_unevenly_lit_has_no_contrast():
    contrast, _ = coarse_contrast(photograph(room(level=30.0, gradient=40.0)), 60.0, 0.0)
    assert contrast[:, 8:-8].max() <= 3


def test_noise_is_measured_though_the_ceiling_is_uneven_and_is_that_of_rounding_at_least():
    picture = draw_lamp(room(600, 600, 60.0, 40.0), (200.0, 150.0), 30.0, 100.0)
    for sigma in (0.8, 2.0, 6.0):
        image = photograph(picture, sigma, np.random.default_rng(1))
        assert noise_sigma(image) == pytest.approx(np.hypot(sigma, 0.29), rel=0.12)
    assert noise_sigma(np.zeros((300, 400), np.uint8)) == pytest.approx(0.3)


def ceiling_with(*spots):
    """Return a contrast with spots, given as row, column, size and level."""
    contrast = np.zeros((60, 80), np.uint8)
    for row, column, size, level in spots:
        contrast[row : row + size, column : column + size] = level
    return contrast


def test_each_spot_is_kept_once_whatever_its_brightness():
    levels = (6, 9, 11, 19, 21, 45, 90, 161, 255)
    contrast = ceiling_with(*((10, 4 + 8 * k, 3, level) for k, level in enumerate(levels)))
    boxes, peaks = find_candidates(contrast, 5.0, LampSettings())
    assert sorted(peaks) == list(levels)
    assert peaks.tolist() == sorted(peaks, reverse=True)
    assert boxes[-1].tolist() == [4 * CELL, 10 * CELL, 7 * CELL, 13 * CELL]


def test_a_bright_lamp_loses_its_halo():
    boxes, peaks = find_candidates(ceiling_with((20, 20, 20, 30), (28, 28, 3, 200)), 5.0, LampSettings())
    assert peaks.tolist() == [200.0]
    assert boxes[0].tolist() == [28 * CELL, 28 * CELL, 31 * CELL, 31 * CELL]


def test_the_brightest_are_taken_where_there_are_many():
    contrast = ceiling_with(*((10, 4 + 7 * k, 3, 100 + k) for k in range(10)))
    assert find_candidates(contrast, 5.0, LampSettings(lamps_max=3))[1].tolist() == [109.0, 108.0, 107.0]
