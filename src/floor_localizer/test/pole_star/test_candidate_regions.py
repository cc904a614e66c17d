"""Candidate regions: small versions of the paper's figures 9 to 13, and the grid compared to explicit counting."""

import numpy as np
import pytest

from floor_localizer.core.pole_star.pole_star_matcher import candidate_regions, farthest_distances, nodes_in_squares
from shirube_core.geometry import SE2

PITCH = 0.06


def test_the_reach_is_the_distance_to_the_farthest_dot():
    image = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 0.0]])
    np.testing.assert_allclose(farthest_distances(image), [5.0, 5.0, 4.0])


def test_nodes_are_those_inside_the_squares():
    rng = np.random.default_rng(4)
    centres, reaches = rng.uniform(-1.0, 1.0, (40, 2)), rng.uniform(0.01, 0.2, 40)
    squares, nodes = nodes_in_squares(centres, reaches, PITCH)
    grid = np.stack(np.meshgrid(np.arange(-30, 31), np.arange(-30, 31)), axis=-1).reshape(-1, 2) * PITCH
    covered = (np.abs(grid[:, None] - centres) <= reaches[:, None]).all(axis=2)
    np.testing.assert_array_equal(np.bincount(squares, minlength=40), covered.sum(axis=0))
    overlaps, by_hand = np.bincount(nodes), covered.sum(axis=1)
    np.testing.assert_array_equal(np.sort(overlaps[overlaps > 0]), np.sort(by_hand[by_hand > 0]))


def test_squares_between_the_nodes_cover_none():
    squares, nodes = nodes_in_squares(np.full((2, 2), 0.03), np.full(2, 0.01), PITCH)
    assert len(squares) == len(nodes) == 0


@pytest.mark.parametrize('seed', range(10))
def test_some_region_holds_all_right_candidates(seed):
    rng = np.random.default_rng(seed)
    image = rng.uniform(-0.045, 0.045, (30, 2))
    floor = SE2(*rng.uniform(-5.0, 5.0, 3)).transform(image)
    regions = candidate_regions(np.arange(30), floor, farthest_distances(image), PITCH, overlap_min=4)
    assert max(len(region) for region in regions) == 30


def test_an_isolated_candidate_is_in_no_region():
    image = np.array([[0.0, 0.0], [0.08, 0.0], [0.0, 0.08], [0.08, 0.08]])
    floor = np.vstack([image, [[3.0, 3.0]]])
    image_dots = np.array([0, 1, 2, 3, 0])
    reaches = farthest_distances(image)[image_dots]
    regions = candidate_regions(image_dots, floor, reaches, PITCH, overlap_min=2)
    assert set(np.concatenate(regions)) == {0, 1, 2, 3}


def test_candidates_of_one_dot_count_once():
    image_dots = np.array([0, 0, 0, 1])
    floor = np.array([[0.0, 0.0], [0.01, 0.0], [0.0, 0.01], [0.01, 0.01]])
    assert candidate_regions(image_dots, floor, np.full(4, 0.1), PITCH, overlap_min=3) == []
    assert len(candidate_regions(image_dots, floor, np.full(4, 0.1), PITCH, overlap_min=2)) > 0
