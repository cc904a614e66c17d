import math

import numpy as np
import pytest
from antialiased_shapes import photograph
from consistency import mahalanobis
from seen_shapes import PRIMITIVES, box, hide, polygon_light, polygon_photo, sides_of, turned_rectangle

from stereo_landmark.core.primitives.primitive import Tolerances, difference
from stereo_landmark.core.primitives.quadrilateral import (
    Quadrilateral,
    QuadrilateralTolerance,
    detect_quadrilaterals,
    match_corner_order,
    refine_quadrilateral,
)
from stereo_landmark.core.primitives.quadrilateral_kernels import (
    best_corner_rotation,
    compare_corners,
    order_corner_pairs,
)

CORNERS = np.array([[22.3, 18.6], [78.1, 24.9], [70.4, 69.7], [28.8, 62.2]])


def _detect(image):
    return detect_quadrilaterals(sides_of(image), PRIMITIVES)


def _ideal(corners, polarity=1):
    return Quadrilateral(np.asarray(corners, float), polarity, 1.0, np.eye(8))


def test_finds_the_drawn_one_and_no_other_clockwise_from_the_upper_left():
    found = _detect(polygon_photo(CORNERS))
    assert len(found) == 1
    np.testing.assert_allclose(found[0].corners, CORNERS, atol=0.4)
    assert found[0].polarity == -1
    assert found[0].seen > 0.8


def _nearest(light, corners):
    """Return the image and the quadrilateral that is nearest to some corners."""
    image = photograph(light, 1.0)
    return image, min(_detect(image), key=lambda q: np.abs(q.corners - corners).max())


def test_finds_one_whose_corner_is_hidden():
    image, best = _nearest(hide(polygon_light(CORNERS), 215.0, box(66, -5, 105, 38)), CORNERS)
    assert np.abs(best.corners - CORNERS).max() < 1.0
    refined = refine_quadrilateral(best, image)
    assert refined is not None
    assert np.abs(refined.corners - CORNERS).max() < 0.15


def test_finds_one_whose_sides_are_broken():
    _, best = _nearest(hide(polygon_light(CORNERS), 140.0, box(46, -5, 56, 95)), CORNERS)
    assert np.abs(best.corners - CORNERS).max() < 0.5


def test_finds_one_with_one_side_of_reversed_polarity():
    plate = box(25.0, 30.0, 75.0, 62.0)
    light = polygon_light(plate, ground=170.0)
    left = polygon_light(box(-9, 35, 25, 57), ground=0.0, contrast=-150.0)
    _, best = _nearest(light + left, plate)
    assert np.abs(best.corners - plate).max() < 1.0


def test_refined_corners_are_unbiased_with_consistent_joint_covariance():
    errors, squares = [], []
    for seed in range(40):
        moved = CORNERS + np.random.default_rng(seed).uniform(-1.0, 1.0, (4, 2))
        image = polygon_photo(moved, seed=seed)
        refined = refine_quadrilateral(_detect(image)[0], image)
        assert refined is not None
        errors.append(refined.corners - moved)
        squares.append(mahalanobis(errors[-1].ravel(), refined.covariance))
    assert np.sqrt(np.mean(np.square(errors))) < 0.03
    assert np.abs(np.mean(errors, axis=0)).max() < 0.015
    assert 0.7 < math.sqrt(np.mean(squares)) < 1.25


def test_order_of_the_taught_one_is_found_again():
    taught = _ideal(turned_rectangle((50, 45), 40.0, 30.0, 0.7))
    turned = taught.rotate_corners(3)
    np.testing.assert_array_equal(match_corner_order(turned, taught).corners, taught.corners)
    assert difference(match_corner_order(turned, taught), taught, Tolerances()) < 1e-9


def test_turning_takes_the_covariance_along():
    deviations = np.diag(np.arange(1.0, 9.0))
    turned = Quadrilateral(CORNERS, 1, 1.0, deviations).rotate_corners(1)
    np.testing.assert_array_equal(np.diag(turned.covariance), [3, 4, 5, 6, 7, 8, 1, 2])


def test_difference_counts_size_and_shape_apart():
    taught = _ideal(turned_rectangle((50, 45), 40.0, 30.0, 0.1))
    larger = _ideal(turned_rectangle((10, 20), 60.0, 45.0, 0.1))
    tolerances = Tolerances(quadrilateral=QuadrilateralTolerance(size=0.5))
    assert difference(larger, taught, tolerances) == pytest.approx(1.0)
    assert difference(_ideal(taught.corners, -1), taught, Tolerances()) == math.inf


SIZE_TOLERANCE, SHAPE_TOLERANCE = np.log(1.5), 0.25


def numbers(rng):
    corners = box(-30.0, -20.0, 30.0, 20.0) + rng.uniform(-8, 8, (4, 2))
    return np.array([*(corners - corners.mean(axis=0)).ravel(), 1.0])


def turned(shape, steps):
    return np.array([*np.roll(shape[:8], -2 * steps), shape[8]])


def test_the_first_corner_plays_no_part():
    rng = np.random.default_rng(1)
    taught, found = numbers(rng), numbers(rng)
    others = np.array([turned(found, steps) for steps in range(4)])
    (values,) = compare_corners(others, taught[None], SIZE_TOLERANCE, SHAPE_TOLERANCE)
    assert values == pytest.approx(np.full(4, values[0]))
    for other in others[1:]:
        again = turned(other, best_corner_rotation(other, taught))
        assert again == pytest.approx(turned(found, best_corner_rotation(found, taught)))


def test_differences_are_those_of_the_definition():
    """Reference implementation: the size, and the largest corner distance after scaling both to the same size."""
    rng = np.random.default_rng(2)
    found, taught = (np.array([numbers(rng) for _ in range(n)]) for n in (6, 4))
    for k, row in enumerate(compare_corners(found, taught, SIZE_TOLERANCE, SHAPE_TOLERANCE)):
        for i, value in enumerate(row):
            one, other = found[i, :8].reshape(4, 2), taught[k, :8].reshape(4, 2)
            scale = np.linalg.norm(one) / np.linalg.norm(other)
            rotated = (np.roll(one, -s, axis=0) for s in range(4))
            nearest = min(rotated, key=lambda c: np.linalg.norm(c - other))
            shift = np.hypot(*(nearest / scale - other).T).max() / (0.5 * np.linalg.norm(other))
            assert value == pytest.approx(max(abs(np.log(scale)) / SIZE_TOLERANCE, shift / SHAPE_TOLERANCE))


def test_corners_of_both_images_come_in_the_taught_order():
    rng = np.random.default_rng(4)
    taught = numbers(rng)
    (pair,) = order_corner_pairs(turned(taught, 1)[None], turned(taught, 3)[None], taught)
    assert pair == pytest.approx(np.tile(taught[:8].reshape(4, 2), 2))
