"""The simulated views of the benchmarks match the paper's conditions."""

from types import ModuleType

import numpy as np
import pytest

pytestmark = pytest.mark.newest_set_only

BENCHMARK = '_paper_views'
PIXEL = 0.13 / 339.44  # [m]


def test_the_floor_and_its_places_are_the_papers(bench: ModuleType) -> None:
    floor, places = bench.paper_floor(1), bench.paper_places()
    assert floor.shape == (91582, 2)
    assert len(np.unique(places, axis=0)) == 1209
    corner = 0.045 * np.sqrt(2.0)
    assert (places >= corner - 1e-9).all()
    assert (places <= np.array([1.8, 9.45]) - corner + 1e-9).all()


def test_image_dots_are_the_floors_dots_seen_from_the_true_pose(bench: ModuleType) -> None:
    floor, places = bench.paper_floor(1), bench.paper_places()[::100]
    errors = []
    for pixels, T_map_view, map_dots in bench.paper_views(floor, places, 0.0, 0.5, 2):
        points_view = T_map_view.inverse().transform(floor[map_dots[map_dots >= 0]])
        # The image's upper edge is ahead (x), its left edge on the left (y).
        expected = 117.0 - points_view[:, ::-1] / PIXEL
        errors.append(pixels[map_dots >= 0] - expected)
    spread = np.concatenate(errors).std(axis=0)
    np.testing.assert_allclose(spread, 1.0, atol=0.1)


def test_rates_are_relative_to_the_floors_dots_in_view(bench: ModuleType) -> None:
    floor, places = bench.paper_floor(1), bench.paper_places()[::300]
    complete = bench.paper_views(floor, places, 0.0, 0.0, 3)
    damaged = bench.paper_views(floor, places, 0.25, 0.5, 3)
    for all_dots, some in zip(complete, damaged):
        in_view = len(all_dots.map_dots)
        assert np.sum(some.map_dots >= 0) == in_view - round(0.25 * in_view)
        assert np.sum(some.map_dots < 0) == round(0.5 * in_view)
        assert set(some.map_dots[some.map_dots >= 0]) < set(all_dots.map_dots)
        assert some.T_map_view == all_dots.T_map_view


def test_views_of_a_photograph_have_its_numbers_of_dots(bench: ModuleType) -> None:
    floor, places = bench.paper_floor(1), bench.paper_places()[::300]
    for view in bench.paper_views(floor, places, 0.0, 0.0, 3, dots=(10, 4)):
        assert np.sum(view.map_dots >= 0) == 10
        assert np.sum(view.map_dots < 0) == 4


def test_a_view_shows_all_dots_of_90_mm_square(bench: ModuleType) -> None:
    floor, places = bench.paper_floor(1), bench.paper_places()[::200]
    for view in bench.paper_views(floor, places, 0.0, 0.0, 4):
        points_view = view.T_map_view.inverse().transform(floor)
        inside = np.flatnonzero(np.abs(points_view).max(axis=1) < 0.045)
        # The camera's 235 pixels are 90.0 mm to within a micrometre.
        assert len(np.setxor1d(inside, view.map_dots)) <= 1
