"""Baselines and their lune counts compared to brute force, and their order."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from search_scenes import view_dots

from floor_localizer.core.constellation.constellation_bases import MOST_CROWDED, list_bases
from floor_localizer.core.constellation.constellation_key import OTHERS

SHORTEST, LONGEST = 0.01, 0.03


@pytest.fixture(scope='module')
def view():
    return view_dots(np.random.default_rng(0).uniform(0.0, 0.09, (33, 2)), 4000.0)


def test_bases_are_all_with_dots_enough_in_their_lenses(view):
    gaps = np.abs(view.z[:, None] - view.z)
    expected = {}
    for i, j in itertools.combinations(range(len(gaps)), 2):
        longest = gaps[i, j] + 2.0 * view.sigma
        crowd = int(np.sum((gaps[i] <= longest) & (gaps[j] <= longest))) - 2
        if SHORTEST <= gaps[i, j] <= LONGEST and OTHERS <= crowd <= MOST_CROWDED:
            expected[i, j] = crowd
    bases = list_bases(view, SHORTEST, LONGEST)
    found = {tuple(ends): crowd for ends, crowd in zip(bases.ends.tolist(), bases.crowds, strict=True)}
    assert len(found) == len(bases.ends) > 10
    assert found == expected


def test_few_dots_come_before_many_and_long_bases_before_short_ones(view):
    bases = list_bases(view, SHORTEST, LONGEST)
    np.testing.assert_array_equal(np.sort(bases.crowds), bases.crowds)
    for crowd in np.unique(bases.crowds):
        lengths = bases.lengths[bases.crowds == crowd]
        assert np.all(np.diff(lengths) < LONGEST / 8)


def test_lengths_are_those_of_the_ends(view):
    bases = list_bases(view, SHORTEST, LONGEST)
    arms = view.points[bases.ends[:, 1]] - view.points[bases.ends[:, 0]]
    np.testing.assert_allclose(np.linalg.norm(arms, axis=1), bases.lengths)


@pytest.mark.parametrize('dots', [1, 2, 5])
def test_few_dots_have_no_base(dots):
    points = np.random.default_rng(1).uniform(0.0, 0.09, (dots, 2))
    assert len(list_bases(view_dots(points, 4000.0), SHORTEST, LONGEST).ends) == 0
