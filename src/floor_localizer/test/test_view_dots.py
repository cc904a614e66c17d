"""The neighbours of every dot are those of a k-d tree."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from floor_localizer.core.dots import sort_neighbours


@pytest.mark.parametrize(('dots', 'most'), [(40, 10), (40, 39), (46, 32), (1000, 32)])
def test_neighbours_are_those_of_a_tree(dots, most):
    points = np.random.default_rng(0).uniform(size=(dots, 2))
    _, expected = cKDTree(points).query(points, k=most + 1)
    np.testing.assert_array_equal(sort_neighbours(points, most), expected[:, 1:])


def test_dots_in_a_crowd_and_far_from_all_others_have_theirs_too():
    rng = np.random.default_rng(1)
    points = np.vstack([rng.normal(0.0, 1e-3, (60, 2)), rng.uniform(50.0, 100.0, (3, 2))])
    _, expected = cKDTree(points).query(points, k=9)
    np.testing.assert_array_equal(sort_neighbours(points, 8), expected[:, 1:])
    # Dots on a line and in one place, too.
    line = np.column_stack([np.arange(8.0), np.zeros(8)])
    np.testing.assert_array_equal(sort_neighbours(line, 3)[0], [1, 2, 3])
    assert sorted(sort_neighbours(np.zeros((5, 2)), 4)[2]) == [0, 1, 3, 4]


@pytest.mark.parametrize(('dots', 'columns'), [(1, 0), (2, 1), (5, 4), (9, 6)])
def test_a_dot_has_no_more_neighbours_than_there_are_others(dots, columns):
    assert sort_neighbours(np.random.default_rng(0).uniform(size=(dots, 2)), 6).shape == (dots, columns)
