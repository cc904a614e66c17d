"""Geometric congruence: the example of the paper's figures 14 to 20, and properties of the pruning."""

import numpy as np
import pytest
from numpy.typing import NDArray

from floor_localizer.core.pole_star.pole_star_matcher import (
    agreement_matrix,
    fit_pose,
    mutual_distances,
    prune_to_congruent,
)
from shirube_core.geometry import SE2

TOLERANCE = 0.0016
PAIRS = ['1a', '1b', '2a', '2b', '3', '4', '5', '6']
IMAGE_DOTS = np.array([0, 0, 1, 1, 2, 3, 4, 5])
# Fig. 18. Its last row contradicts its last column; the column fits the printed sums and is taken for both.
FIGURE_18 = np.array(
    [
        [0, 0, 1, 1, 1, 1, 1, 1],
        [0, 0, 0, 1, 1, 0, 0, 0],
        [1, 0, 0, 0, 1, 0, 0, 1],
        [1, 1, 0, 0, 1, 1, 1, 0],
        [1, 1, 1, 1, 0, 1, 1, 0],
        [1, 0, 0, 1, 1, 0, 1, 1],
        [1, 0, 0, 1, 1, 1, 0, 1],
        [1, 0, 1, 0, 0, 1, 1, 0],
    ],
    dtype=bool,
)


def polar(radius: float, degrees: float) -> NDArray:
    return radius * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])


def mirrored(point: NDArray, a: NDArray, b: NDArray) -> NDArray:
    """Mirror a point in the line through a and b: it keeps its distances to both."""
    along = (b - a) / np.linalg.norm(b - a)
    return a + 2.0 * ((point - a) @ along) * along - (point - a)


def agreement(image: NDArray[np.float64], floor: NDArray[np.float64]) -> NDArray[np.bool_]:
    C_d = mutual_distances(image[IMAGE_DOTS], IMAGE_DOTS)
    F_d = mutual_distances(SE2(1.0, 2.0, 0.6).transform(floor), IMAGE_DOTS)
    return agreement_matrix(C_d, F_d, TOLERANCE)


def remaining(matrix: NDArray[np.bool_]) -> list[str]:
    return [PAIRS[i] for i in prune_to_congruent(matrix)]


def image_and_floor_of_figure_18() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place dots so that the candidates agree as printed; C1, C4 and C5 are collinear."""
    C1, C3, C4, C5 = np.zeros(2), polar(0.050, 70.0), polar(0.035, 20.0), polar(0.060, 20.0)
    C2, C6 = polar(0.040, 130.0), polar(0.045, 80.0)
    image = np.array([C1, C2, C3, C4, C5, C6])
    F_1b, F_2a, F_6 = mirrored(C1, C2, C3), mirrored(C2, C1, C3), mirrored(C6, C1, C5)
    return image, np.array([C1, F_1b, F_2a, C2, C3, C4, C5, F_6])


def test_figure_18_comes_out_of_coordinates():
    matrix = agreement(*image_and_floor_of_figure_18())
    np.testing.assert_array_equal(matrix, FIGURE_18)
    np.testing.assert_array_equal(matrix.sum(axis=0), [6, 2, 3, 5, 6, 5, 5, 4])


def test_the_rule_keeps_2b_of_figure_18_as_it_agrees_with_all_that_remain():
    assert remaining(FIGURE_18) == ['1a', '2b', '3', '4', '5']


def test_the_pairs_of_figure_19_remain_where_both_candidates_of_2_are_wrong():
    C1, C3, C4, C5 = np.zeros(2), polar(0.050, 70.0), polar(0.035, 20.0), polar(0.060, -10.0)
    C2, C6 = polar(0.040, 130.0), polar(0.045, 250.0)
    image = np.array([C1, C2, C3, C4, C5, C6])
    F_1b, F_2a = mirrored(C1, C3, C4), mirrored(C2, C1, C3)
    F_2b, F_6 = mirrored(C2, C4, C5), mirrored(C6, C1, C5)
    matrix = agreement(image, np.array([C1, F_1b, F_2a, F_2b, C3, C4, C5, F_6]))
    assert remaining(matrix) == ['1a', '3', '4', '5']
    kept = prune_to_congruent(matrix)
    np.testing.assert_array_equal(matrix[np.ix_(kept, kept)].sum(axis=0), [3, 3, 3, 3])


def test_distances_within_an_image_dot_are_not_available():
    distances = mutual_distances(np.random.default_rng(5).uniform(size=(8, 2)), IMAGE_DOTS)
    np.testing.assert_array_equal(np.isnan(distances), IMAGE_DOTS[:, None] == IMAGE_DOTS)
    np.testing.assert_array_equal(distances, distances.T)
    assert not agreement_matrix(distances, distances, TOLERANCE).diagonal().any()


def test_differences_count_up_to_the_tolerance():
    C_d = np.array([[np.nan, 0.050], [0.050, np.nan]])
    assert agreement_matrix(C_d, C_d + 0.0015, TOLERANCE).sum() == 2
    assert agreement_matrix(C_d, C_d - 0.0017, TOLERANCE).sum() == 0


@pytest.mark.parametrize('seed', range(20))
def test_what_remains_agrees_with_each_other(seed):
    rng = np.random.default_rng(seed)
    matrix = np.triu(rng.random((40, 40)) < rng.uniform(0.05, 0.9), 1)
    matrix |= matrix.T
    kept = prune_to_congruent(matrix)
    assert (matrix[np.ix_(kept, kept)].sum(axis=0) == len(kept) - 1).all()


@pytest.mark.parametrize('seed', range(10))
def test_right_pairs_survive_among_chance_ones(seed):
    rng = np.random.default_rng(seed)
    image = rng.uniform(-0.045, 0.045, (30, 2))
    image_dots = np.concatenate([np.arange(15), rng.integers(0, 30, 60)])
    floor = np.vstack([SE2(0.0, 0.0, 2.0).transform(image[:15]), rng.uniform(-0.08, 0.08, (60, 2))])
    C_d, F_d = mutual_distances(image[image_dots], image_dots), mutual_distances(floor, image_dots)
    matrix = agreement_matrix(C_d, F_d, TOLERANCE)
    assert set(range(15)) <= set(prune_to_congruent(matrix))
    assert len(prune_to_congruent(np.zeros((0, 0), dtype=bool))) == 0


RNG = np.random.default_rng(8)
VIEW = RNG.uniform(-0.045, 0.045, (20, 2))


@pytest.mark.parametrize('yaw', [-3.1, -1.0, 0.0, 0.4, 2.0, 3.1])
def test_the_pose_that_moved_the_dots_comes_back(yaw):
    T_map_view = SE2(1.2, 7.5, yaw)
    fitted = fit_pose(VIEW, T_map_view.transform(VIEW))
    assert fitted.distance_to(T_map_view) < 1e-12
    assert abs(fitted.yaw_to(T_map_view)) < 1e-12


def test_no_pose_nearby_has_smaller_residuals():
    map_points = SE2(0.3, 0.2, 1.0).transform(VIEW) + RNG.normal(0.0, 0.0004, VIEW.shape)
    fitted = fit_pose(VIEW, map_points)
    best = np.sum((fitted.transform(VIEW) - map_points) ** 2)
    for step in RNG.normal(0.0, 1e-4, (100, 3)):
        near = SE2(fitted.x + step[0], fitted.y + step[1], fitted.yaw + step[2])
        assert np.sum((near.transform(VIEW) - map_points) ** 2) >= best


def test_mirrored_dots_are_not_fitted():
    mirrored = VIEW * (1.0, -1.0)
    residuals = fit_pose(VIEW, mirrored).transform(VIEW) - mirrored
    assert np.linalg.norm(residuals, axis=1).max() > 0.01
