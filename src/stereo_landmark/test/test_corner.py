import math

import numpy as np
import pytest
from consistency import mahalanobis
from seen_shapes import PRIMITIVES, polygon_photo, sides_of

from stereo_landmark.core.primitives.corner import Corner, CornerTolerance, detect_corners, refine_corner
from stereo_landmark.core.primitives.primitive import Tolerances, difference

CORNERS = np.array([[22.3, 18.6], [78.1, 24.9], [70.4, 69.7], [28.8, 62.2]])


def _detect(image):
    return detect_corners(sides_of(image), PRIMITIVES)


def _nearest(corners, vertex):
    return min(corners, key=lambda corner: np.hypot(*(corner.vertex - vertex)))


def test_parameters_and_arms_are_those_of_the_drawn_corner():
    found = _detect(polygon_photo(CORNERS))
    for k in range(4):
        corner = _nearest(found, CORNERS[k])
        arms = np.array([CORNERS[k - 1], CORNERS[(k + 1) % 4]]) - CORNERS[k]
        lengths = np.hypot(*arms.T)
        inward = (arms / lengths[:, None]).sum(axis=0)
        turn = corner.bisector - math.atan2(inward[1], inward[0])
        assert np.hypot(*(corner.vertex - CORNERS[k])) < 0.3
        assert corner.angle == pytest.approx(math.acos(arms[0] @ arms[1] / lengths.prod()), abs=0.03)
        assert math.remainder(turn, 2 * math.pi) == pytest.approx(0.0, abs=0.03)
        np.testing.assert_allclose(corner.arms * corner.arm_lengths[:, None], arms[::-1], atol=4.0)
        assert corner.polarity == -1


def test_a_bright_inside_has_the_other_polarity_and_is_no_match():
    dark, bright = (
        _nearest(_detect(polygon_photo(CORNERS, ground=ground, contrast=contrast)), CORNERS[1])
        for ground, contrast in ((180.0, -80.0), (80.0, 90.0))
    )
    assert (dark.polarity, bright.polarity) == (-1, 1)
    assert difference(bright, dark, Tolerances()) == math.inf
    assert difference(dark, dark, Tolerances()) == 0.0


def test_difference_reaches_one_at_the_tolerance():
    taught, found = (Corner(np.zeros(2), 1.5, turn, np.ones(2), 1, np.eye(2)) for turn in (3.1, -3.1))
    gap = 2 * math.pi - 6.2
    assert difference(found, taught, Tolerances(corner=CornerTolerance(bisector=gap))) == pytest.approx(1.0)


def test_refined_vertices_are_unbiased_with_consistent_covariance():
    errors, squares = [], []
    for seed in range(40):
        moved = CORNERS + np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
        image = polygon_photo(moved, seed=seed)
        for corner in _detect(image):
            truth = moved[np.argmin(np.hypot(*(moved - corner.vertex).T))]
            refined = refine_corner(corner, image)
            assert refined is not None
            vertex = refined.image_points()['vertex']
            errors.append(vertex.position - truth)
            squares.append(mahalanobis(errors[-1], vertex.covariance))
    assert len(errors) >= 150
    assert np.sqrt(np.mean(np.square(errors))) < 0.03
    assert np.abs(np.mean(errors, axis=0)).max() < 0.006
    assert 0.7 < math.sqrt(np.mean(squares)) < 1.3


def test_nothing_is_refined_where_there_is_no_corner():
    blank = np.random.default_rng(0).integers(100, 140, (90, 100)).astype(np.uint8)
    corner = Corner(np.array([50.0, 40.0]), 1.5, 0.3, np.array([3.0, 3.0]), 1, np.eye(2))
    assert refine_corner(corner, blank) is None
