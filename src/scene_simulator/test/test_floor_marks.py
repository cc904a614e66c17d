"""Random outlines have their areas and centroids."""

import math

import numpy as np
import pytest

from scene_simulator.floor.marks import polygon_areas, polygon_centroids, random_chips, random_ribbons

TRIANGLE = np.array([[[0.0, 0.0], [3.0, 0.0], [0.0, 6.0]]])


def test_area_and_centroid_of_a_triangle() -> None:
    assert polygon_areas(TRIANGLE)[0] == pytest.approx(9.0)
    assert polygon_areas(TRIANGLE[:, ::-1])[0] == pytest.approx(-9.0)
    np.testing.assert_allclose(polygon_centroids(TRIANGLE), [[1.0, 2.0]])


def test_chips_have_their_area_and_their_centroid_in_the_origin() -> None:
    rng = np.random.default_rng(1)
    diameters = rng.uniform(0.002, 0.003, 500)
    chips = random_chips(diameters, rng)
    np.testing.assert_allclose(polygon_areas(chips), math.pi / 4.0 * diameters**2, rtol=1e-9)
    np.testing.assert_allclose(polygon_centroids(chips), np.zeros((500, 2)), atol=1e-12)


def test_chips_have_no_preferred_direction() -> None:
    chips = random_chips(np.full(4000, 0.0025), np.random.default_rng(2))
    spread = np.cov(chips.reshape(-1, 2).T)
    assert spread[0, 0] == pytest.approx(spread[1, 1], rel=0.05)
    assert abs(spread[0, 1]) < 0.05 * spread[0, 0]


def test_ribbons_have_the_area_of_their_length_and_width() -> None:
    lengths, widths = np.full(50, 0.04), np.full(50, 0.0001)
    straight = random_ribbons(lengths, widths, 0.1, np.random.default_rng(3))
    np.testing.assert_allclose(np.abs(polygon_areas(straight)), 0.04 * 0.0001, rtol=0.06)
