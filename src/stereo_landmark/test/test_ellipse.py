import math

import numpy as np
import pytest
from antialiased_shapes import photograph
from consistency import mahalanobis
from seen_shapes import (
    PRIMITIVES,
    box,
    ellipse_light,
    ellipse_photo,
    hide,
    polygon_photo,
    segments_of,
    turned_rectangle,
)

from stereo_landmark.core.primitives.ellipse import Ellipse, EllipseTolerance, detect_ellipses, refine_ellipse
from stereo_landmark.core.primitives.primitive import Tolerances, difference


def _detect(image):
    return detect_ellipses(segments_of(image), PRIMITIVES)


def _refined(image):
    refined = refine_ellipse(_detect(image)[0], image)
    assert refined is not None
    return refined


@pytest.mark.parametrize(
    ('axes', 'tilt'), [((30.0, 20.0), 0.5), ((25.0, 10.0), -1.1), ((12.0, 11.9), 0.0), ((7.0, 6.0), 1.5)]
)
def test_finds_the_drawn_one_and_no_other(axes, tilt):
    found = _detect(ellipse_photo((50.3, 44.7), axes, tilt))
    assert len(found) == 1
    np.testing.assert_allclose(found[0].centre, [50.3, 44.7], atol=0.1)
    np.testing.assert_allclose(found[0].semi_axes, axes, atol=0.25)
    if axes[0] > 1.1 * axes[1]:
        assert math.remainder(found[0].tilt - tilt, math.pi) == pytest.approx(0.0, abs=0.05)
    assert found[0].polarity == -1


def test_finds_a_broken_outline_from_arcs_of_several_segments():
    light = ellipse_light((50.3, 44.7), (30.0, 24.0), 0.4)
    light = hide(hide(light, 140.0, box(44, -5, 56, 95)), 140.0, box(-5, 40, 105, 50))
    found = _detect(photograph(light, 1.0))
    assert len(found) >= 1
    np.testing.assert_allclose(found[0].parameters[:4], [50.3, 44.7, 30.0, 24.0], atol=0.4)
    assert found[0].seen < 0.9


def test_finds_and_refines_one_that_is_hidden_by_a_third():
    light = hide(ellipse_light((50.3, 44.7), (30.0, 24.0), 0.4), 60.0, box(62, -5, 105, 95))
    refined = _refined(photograph(light, 1.0))
    error = refined.centre - [50.3, 44.7]
    assert np.hypot(*error) < 0.2
    assert mahalanobis(error, refined.covariance[:2, :2]) < 8.0


def test_a_square_is_no_ellipse():
    assert _detect(polygon_photo(turned_rectangle((50, 45), 40.0, 40.0, 0.2))) == []


def test_refined_centres_are_unbiased_with_consistent_covariance():
    rng = np.random.default_rng(3)
    errors, squares, axes_errors = [], [], []
    for seed in range(60):
        centre, a = rng.uniform([45, 40], [55, 50]), rng.uniform(14.0, 32.0)
        axes, tilt = (a, a * rng.uniform(0.6, 0.95)), rng.uniform(-1.5, 1.5)
        refined = _refined(ellipse_photo(centre, axes, tilt, seed=seed))
        errors.append(refined.centre - centre)
        axes_errors.append(refined.semi_axes - axes)
        turn = math.remainder(refined.tilt - tilt, math.pi)
        error = np.array([*errors[-1], *axes_errors[-1], turn])
        squares.append(mahalanobis(error, refined.covariance))
    assert np.sqrt(np.mean(np.square(errors))) < 0.012
    assert np.abs(np.mean(errors, axis=0)).max() < 0.004
    # Blur shifts the half-level point of a curved edge inward; refinement corrects it.
    assert np.abs(np.mean(axes_errors, axis=0)).max() < 0.006
    assert 0.7 < math.sqrt(np.mean(squares)) < 1.2


@pytest.mark.parametrize('blur', [0.0, 2.5])
def test_blur_does_not_move_small_circles(blur):
    refined = _refined(ellipse_photo((50.3, 44.7), (10.0, 10.0), 0.0, blur=blur, noise=0.3))
    np.testing.assert_allclose(refined.centre, [50.3, 44.7], atol=0.02)
    np.testing.assert_allclose(refined.semi_axes, 10.0, atol=0.06)


def test_needles_that_cross_the_outline_are_left_out():
    light = ellipse_light((50.3, 44.7), (25.0, 25.0), 0.0)
    refined = _refined(photograph(hide(light, 100.0, turned_rectangle((72, 45), 30.0, 5.0, 0.1)), 1.0))
    assert np.hypot(*(refined.centre - [50.3, 44.7])) < 0.04


def test_nothing_is_refined_where_there_is_no_ellipse():
    blank = np.full((90, 100), 120, np.uint8)
    guess = Ellipse(np.array([50.0, 45.0]), np.array([20.0, 15.0]), 0.2, 1, 1.0, np.eye(5))
    assert refine_ellipse(guess, blank) is None


def test_tilt_counts_for_flat_ones_only():
    tolerance = Tolerances(ellipse=EllipseTolerance(axes=0.5, tilt=0.2))

    def differences(one, other):
        made = (Ellipse(np.zeros(2), np.array(axes), t, p, 1.0, np.eye(5)) for *axes, t, p in (one, other))
        return difference(*made, tolerance)

    assert differences((20.0, 20.0, 0.9, 1), (20.0, 20.0, 0.0, 1)) == 0.0
    assert differences((20.0, 5.0, 0.9, 1), (20.0, 5.0, 0.0, 1)) > 1.0
    assert differences((30.0, 20.0, 0.0, 1), (20.0, 20.0, 0.0, 1)) == pytest.approx(1.0)
    assert differences((20.0, 20.0, 0.0, -1), (20.0, 20.0, 0.0, 1)) == math.inf
