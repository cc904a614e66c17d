import cv2
import numpy as np
import pytest
from drawn_floor import disc_coverage, photograph

from floor_localizer.core.dot_extraction.centroids import measure_blobs
from floor_localizer.core.dot_extraction.labelling import grow_labels, label_blobs


def measure(image, floor, coverage):
    planes = image.reshape(*image.shape[:2], -1)
    background = np.broadcast_to(np.float32(floor), planes.shape).copy()
    mask = (coverage > 0.3).astype(np.uint8)
    labels, boxes = label_blobs(mask)
    grow_labels(labels, boxes)
    return measure_blobs(planes, background, mask, labels, boxes)


@pytest.mark.parametrize('diameter', [5.0, 8.0, 30.0])
@pytest.mark.parametrize('phase', [0.0, 0.3, 0.5])
def test_measures_place_area_and_contrast_of_a_disc(diameter, phase):
    coverage = disc_coverage([[70.0 + phase, 80.0 - phase]], diameter)
    blobs = measure(photograph(coverage), 160.0, coverage)
    np.testing.assert_allclose(blobs.pixels, [[70.0 + phase, 80.0 - phase]], atol=0.03)
    np.testing.assert_allclose(blobs.areas, np.pi * diameter**2 / 4, rtol=0.07)
    np.testing.assert_allclose(blobs.contrasts, 130.0 / 160.0, rtol=0.04)


def test_second_moments_are_those_of_an_ellipse():
    v, u = np.mgrid[:160, :160]
    coverage = (np.hypot((u - 80.0) / 12.0, (v - 70.0) / 5.0) < 1.0).astype(float)
    blobs = measure(photograph(coverage), 160.0, coverage)
    np.testing.assert_allclose(blobs.covariances, [[36.0, 0.0, 6.25]], atol=1.0)


def test_a_wrong_background_is_corrected_by_the_ring():
    coverage = disc_coverage([[70.3, 80.1]], 8.0)
    right = measure(photograph(coverage), 160.0, coverage)
    wrong = measure(photograph(coverage), 176.0, coverage)
    np.testing.assert_allclose(wrong.pixels, right.pixels, atol=1e-3)
    np.testing.assert_allclose(wrong.areas, right.areas, rtol=1e-3)


def test_twice_the_noise_gives_twice_the_noise_of_the_centroid():
    coverage = disc_coverage([[70.3, 80.1]], 8.0)
    sigmas = [measure(photograph(coverage, noise=n), 160.0, coverage).noises[0] for n in (0.0, 2.0, 4.0, 8.0)]
    assert np.all(np.diff(sigmas) > 0.0)
    assert sigmas[3] == pytest.approx(2.0 * sigmas[2], rel=0.35)


def test_colour_counts_along_the_difference_from_the_floor():
    coverage = disc_coverage([[70.3, 80.1]], 8.0)
    floor, dot = (120.0, 120.0, 120.0), (60.0, 120.0, 180.0)
    blobs = measure(photograph(coverage, floor=floor, dot=dot), 120.0, coverage)
    np.testing.assert_allclose(blobs.pixels, [[70.3, 80.1]], atol=0.03)
    np.testing.assert_allclose(blobs.contrasts, np.hypot(0.5, 0.5), rtol=0.02)


def test_saturated_pixels_and_luminance_steps_are_measured():
    coverage = disc_coverage([[40.0, 40.0], [120.0, 120.0]], 9.0)
    image = photograph(coverage, floor=80.0, dot=200.0)
    image[36:45, 36:41] = 255
    blobs = measure(image, 80.0, coverage)
    assert blobs.clipped[0] > 0.2
    assert blobs.clipped[1] == 0.0
    assert (blobs.steps == 0.0).all()


def test_a_blob_at_the_border_is_not_measured():
    coverage = disc_coverage([[1.0, 80.0], [158.5, 20.0], [80.0, 80.0]], 9.0)
    contrasts = measure(photograph(coverage), 160.0, coverage).contrasts
    assert sorted(contrasts > 0.0) == [False, False, True]


def test_a_faint_neighbour_moves_the_outer_half_of_the_edge_against_the_inner():
    coverage = disc_coverage([[70.3, 80.1]], 8.0)
    alone = measure(photograph(coverage), 160.0, coverage).edge_asymmetries[0]
    with_faint = np.maximum(coverage, 0.4 * disc_coverage([[75.5, 80.1]], 6.0))
    assert alone < 0.1
    assert measure(photograph(with_faint), 160.0, with_faint).edge_asymmetries[0] > 0.5


def test_a_blurred_edge_is_softer():
    coverage = disc_coverage([[70.3, 80.1]], 12.0)
    blurred = cv2.GaussianBlur(coverage, (0, 0), 2.0)
    sharp, soft = (measure(photograph(c), 160.0, c).softness[0] for c in (coverage, blurred))
    assert soft > 2.0 * sharp
