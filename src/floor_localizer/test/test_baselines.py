"""Baselines and their lune counts compared to brute force, and their order."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from search_scenes import view_dots

from floor_localizer.core.constellation.baselines import VIEW_LUNE_DOTS_MAX, list_baselines
from floor_localizer.core.constellation.constellation_key import INNER_DOTS

SHORTEST, LONGEST = 0.01, 0.03


@pytest.fixture(scope='module')
def view():
    return view_dots(np.random.default_rng(0).uniform(0.0, 0.09, (33, 2)), 4000.0)


def test_baselines_are_all_with_enough_dots_in_their_lunes(view):
    gaps = np.abs(view.z[:, None] - view.z)
    expected = {}
    for i, j in itertools.combinations(range(len(gaps)), 2):
        longest = gaps[i, j] + 2.0 * view.sigma
        count = int(np.sum((gaps[i] <= longest) & (gaps[j] <= longest))) - 2
        if SHORTEST <= gaps[i, j] <= LONGEST and INNER_DOTS <= count <= VIEW_LUNE_DOTS_MAX:
            expected[i, j] = count
    baselines = list_baselines(view, SHORTEST, LONGEST)
    found = {
        tuple(ends): count for ends, count in zip(baselines.ends.tolist(), baselines.lune_counts, strict=True)
    }
    assert len(found) == len(baselines.ends) > 10
    assert found == expected


def test_few_dots_come_before_many_and_long_baselines_before_short_ones(view):
    baselines = list_baselines(view, SHORTEST, LONGEST)
    np.testing.assert_array_equal(np.sort(baselines.lune_counts), baselines.lune_counts)
    for count in np.unique(baselines.lune_counts):
        lengths = baselines.lengths[baselines.lune_counts == count]
        assert np.all(np.diff(lengths) < LONGEST / 8)


def test_lengths_are_those_of_the_ends(view):
    baselines = list_baselines(view, SHORTEST, LONGEST)
    edges = view.points[baselines.ends[:, 1]] - view.points[baselines.ends[:, 0]]
    np.testing.assert_allclose(np.linalg.norm(edges, axis=1), baselines.lengths)


@pytest.mark.parametrize('dots', [1, 2, 5])
def test_few_dots_have_no_baseline(dots):
    points = np.random.default_rng(1).uniform(0.0, 0.09, (dots, 2))
    assert len(list_baselines(view_dots(points, 4000.0), SHORTEST, LONGEST).ends) == 0
