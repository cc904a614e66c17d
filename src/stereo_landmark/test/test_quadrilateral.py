import math

import numpy as np
import pytest
from antialiased_shapes import coverage, photograph, polygon_intervals
from seen_shapes import PRIMITIVES, SIZE, mahalanobis, polygon_photo, sides_of, turned_rectangle

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


def test_finds_one_whose_corner_is_hidden():
    light = 180.0 - 80.0 * coverage(polygon_intervals(CORNERS), SIZE, 0.7)
    hider = coverage(polygon_intervals([[66, -5], [105, -5], [105, 38], [66, 38]]), SIZE, 0.7)
    image = photograph(light * (1 - hider) + 215.0 * hider, 1.0)
    best = min(_detect(image), key=lambda q: np.abs(q.corners - CORNERS).max())
    assert np.abs(best.corners - CORNERS).max() < 1.0
    refined = refine_quadrilateral(best, image)
    assert refined is not None
    assert np.abs(refined.corners - CORNERS).max() < 0.15


def test_finds_one_whose_sides_are_broken():
    light = 180.0 - 80.0 * coverage(polygon_intervals(CORNERS), SIZE, 0.7)
    hider = coverage(polygon_intervals([[46, -5], [56, -5], [56, 95], [46, 95]]), SIZE, 0.7)
    image = photograph(light * (1 - hider) + 140.0 * hider, 1.0)
    best = min(_detect(image), key=lambda q: np.abs(q.corners - CORNERS).max())
    assert np.abs(best.corners - CORNERS).max() < 0.5


def test_finds_one_with_one_side_of_reversed_polarity():
    box = np.array([[25.0, 30.0], [75.0, 30.0], [75.0, 62.0], [25.0, 62.0]])
    inside = coverage(polygon_intervals(box), SIZE, 0.7)
    left = coverage(polygon_intervals([[-9, 35], [25, 35], [25, 57], [-9, 57]]), SIZE, 0.7)
    best = min(
        _detect(photograph(170.0 - 80.0 * inside - 150.0 * left, 1.0)),
        key=lambda q: np.abs(q.corners - box).max(),
    )
    assert np.abs(best.corners - box).max() < 1.0


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
    assert difference(
        larger, taught, Tolerances(quadrilateral=QuadrilateralTolerance(size=0.5))
    ) == pytest.approx(1.0)
    assert difference(_ideal(taught.corners, -1), taught, Tolerances()) == math.inf


def test_corners_and_centre_are_points_to_choose():
    points = _detect(polygon_photo(CORNERS))[0].image_points()
    assert set(points) == {'corner_0', 'corner_1', 'corner_2', 'corner_3', 'centre'}
    np.testing.assert_allclose(points['corner_2'].position, CORNERS[2], atol=0.4)
    assert np.linalg.eigvalsh(points['centre'].covariance).min() > 0.0


SIZE_TOLERANCE, SHAPE_TOLERANCE = np.log(1.5), 0.25


def numbers(rng, polarity=1.0):
    corners = np.array([[-30.0, -20.0], [30.0, -20.0], [30.0, 20.0], [-30.0, 20.0]]) + rng.uniform(
        -8, 8, (4, 2)
    )
    return np.array([*(corners - corners.mean(axis=0)).ravel(), polarity])


def turned(shape, steps):
    return np.array([*np.roll(shape[:8], -2 * steps), shape[8]])


def test_the_first_corner_plays_no_part():
    rng = np.random.default_rng(1)
    taught, found = numbers(rng), numbers(rng)
    plain = compare_corners(found[None], taught[None], SIZE_TOLERANCE, SHAPE_TOLERANCE)[0, 0]
    for steps in range(4):
        other = turned(found, steps)
        assert compare_corners(other[None], taught[None], SIZE_TOLERANCE, SHAPE_TOLERANCE)[
            0, 0
        ] == pytest.approx(plain)
        assert turned(other, best_corner_rotation(other, taught)) == pytest.approx(
            turned(found, best_corner_rotation(found, taught))
        )


def test_differences_are_those_of_the_definition():
    """Reference implementation: the size, and the largest corner distance after scaling both to the same size."""
    rng = np.random.default_rng(2)
    found, taught = (np.array([numbers(rng) for _ in range(n)]) for n in (6, 4))
    for k, row in enumerate(compare_corners(found, taught, SIZE_TOLERANCE, SHAPE_TOLERANCE)):
        for i, value in enumerate(row):
            one, other = found[i, :8].reshape(4, 2), taught[k, :8].reshape(4, 2)
            scale = np.linalg.norm(one) / np.linalg.norm(other)
            nearest = min(
                (np.roll(one, -s, axis=0) for s in range(4)), key=lambda c: np.linalg.norm(c - other)
            )
            shift = np.hypot(*(nearest / scale - other).T).max() / (0.5 * np.linalg.norm(other))
            assert value == pytest.approx(max(abs(np.log(scale)) / SIZE_TOLERANCE, shift / SHAPE_TOLERANCE))


def test_another_polarity_is_infinitely_different_and_another_size_too_much():
    rng = np.random.default_rng(3)
    taught = numbers(rng)
    dark, large = taught.copy(), taught.copy()
    dark[8], large[:8] = -1.0, 2.0 * taught[:8]
    other, size = compare_corners(np.array([dark, large]), taught[None], SIZE_TOLERANCE, SHAPE_TOLERANCE)[0]
    assert np.isinf(other)
    assert size == pytest.approx(np.log(2.0) / SIZE_TOLERANCE)


def test_corners_of_both_images_come_in_the_taught_order():
    rng = np.random.default_rng(4)
    taught = numbers(rng)
    (pair,) = order_corner_pairs(turned(taught, 1)[None], turned(taught, 3)[None], taught)
    assert pair[:, :2] == pytest.approx(taught[:8].reshape(4, 2))
    assert pair[:, 2:] == pytest.approx(taught[:8].reshape(4, 2))
