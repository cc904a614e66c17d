"""Random outlines have their areas and centroids; painted polygons cover each pixel by their exact area."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_simulator.floor.dot_floor import polygon_areas, polygon_centroids, random_chips, random_ribbons
from scene_simulator.floor.view import paint_polygons


def coverage_of(polygon: NDArray[np.float64], shape: tuple[int, int] = (30, 40)) -> NDArray[np.float32]:
    layer, covered = np.zeros((*shape, 1), np.float32), np.zeros(shape, np.float32)
    paint_polygons(layer, covered, polygon[None], np.ones((1, 1)), np.ones(1))
    np.testing.assert_array_equal(layer[..., 0], covered)
    return covered


CHIPS = np.array((18.3, 14.7)) + random_chips(np.full(20, 7.0), np.random.default_rng(1))


@pytest.mark.parametrize('chip', CHIPS)
def test_coverage_has_the_area_and_the_centroid_of_the_polygon(chip: NDArray[np.float64]) -> None:
    covered = coverage_of(chip).astype(float)
    v, u = np.mgrid[:30, :40]
    assert covered.sum() == pytest.approx(abs(polygon_areas(chip[None])[0]), rel=1e-5)
    centroid = [(covered * u).sum() / covered.sum(), (covered * v).sum() / covered.sum()]
    # Every pixel's fraction counts at its middle, hence the small rest.
    np.testing.assert_allclose(centroid, polygon_centroids(chip[None])[0], atol=0.01)


def test_a_polygon_over_the_border_covers_what_is_inside() -> None:
    square = np.array([[-5.0, -7.0], [9.25, -7.0], [9.25, 3.75], [-5.0, 3.75]])
    covered = coverage_of(square)
    assert covered[:4, :9].min() == 1.0
    assert covered.sum() == pytest.approx(9.75 * 4.25, rel=1e-6)


def test_a_polygon_outside_covers_nothing() -> None:
    assert coverage_of(CHIPS[0] + (100.0, 0.0)).sum() == 0.0
    assert coverage_of(CHIPS[0] - (0.0, 100.0)).sum() == 0.0


def test_later_polygons_hide_earlier_ones_by_their_opacity() -> None:
    square = np.array([[-1.0, -1.0], [5.0, -1.0], [5.0, 5.0], [-1.0, 5.0]])
    layer, covered = np.zeros((4, 4, 1), np.float32), np.zeros((4, 4), np.float32)
    paint_polygons(layer, covered, np.stack([square] * 2), np.array([[0.8], [0.2]]), np.array([1.0, 0.25]))
    np.testing.assert_allclose(layer, 0.75 * 0.8 + 0.25 * 0.2, rtol=1e-6)
    np.testing.assert_allclose(covered, 1.0)


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
