"""Baselines and their lune counts compared to brute force, and their order."""

import itertools

import numpy as np
import pytest
from search_scenes import view_dots

from floor_localizer.core.constellation.baselines import (
    MAX_QUADRUPLES,
    VIEW_LUNE_DOTS_MAX,
    distance,
    dots_in_lune,
    list_baselines,
    list_quadruples,
)
from floor_localizer.core.constellation.constellation_key import INNER_DOTS


def gaps(points):
    return np.linalg.norm(points[:, None] - points, axis=2)


@pytest.mark.parametrize('seed', range(6))
def test_lune_holds_the_dots_near_to_both_ends(seed):
    points = np.random.default_rng(seed).uniform(0.0, 1.0, (20, 2))
    lune = np.empty(20, dtype=np.int64)
    near = gaps(points)
    longest = distance(points, 0, 1)
    assert longest == pytest.approx(near[0, 1])
    count = dots_in_lune(points, 0, 1, np.argsort(near[0]), longest, lune)
    assert set(lune[:count]) == {k for k in range(2, 20) if max(near[0, k], near[1, k]) <= longest}


def test_a_full_lune_takes_no_more():
    points = np.vstack([[[0.0, 0.0], [1.0, 0.0]], np.random.default_rng(0).uniform(0.4, 0.6, (60, 2))])
    lune = np.empty(24, dtype=np.int64)
    assert dots_in_lune(points, 0, 1, np.argsort(gaps(points)[0]), 1.0, lune) == len(lune)


@pytest.mark.parametrize('size', [0, 3, 4, 6, 10])
@pytest.mark.parametrize('longest', [0.4, 0.7, 2.0])
def test_quadruples_are_all_that_keep_within_the_length(size, longest):
    points = np.random.default_rng(size).uniform(0.0, 1.0, (15, 2))
    lune = np.random.default_rng(1).permutation(15)[:size]
    quadruples = np.empty((MAX_QUADRUPLES, 4), dtype=np.int64)
    count = list_quadruples(points, lune, longest, quadruples)
    near = gaps(points) <= longest
    expected = {
        frozenset(group)
        for group in itertools.combinations(lune, 4)
        if all(near[i, j] for i, j in itertools.combinations(group, 2))
    }
    found = [frozenset(group) for group in quadruples[:count]]
    assert len(found) == len(set(found))
    assert set(found) == expected


def test_quadruples_beyond_the_capacity_are_left_out():
    points = np.random.default_rng(0).uniform(0.0, 1.0, (20, 2))
    quadruples = np.empty((7, 4), dtype=np.int64)
    assert list_quadruples(points, np.arange(20), 2.0, quadruples) == 7


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
            expected[i, j] = count, pytest.approx(gaps[i, j])
    baselines = list_baselines(view, SHORTEST, LONGEST)
    counts = zip(baselines.lune_counts, baselines.lengths, strict=True)
    found = dict(zip(map(tuple, baselines.ends.tolist()), counts, strict=True))
    assert len(found) == len(baselines.ends) > 10
    assert found == expected


def test_few_dots_come_before_many_and_long_baselines_before_short_ones(view):
    baselines = list_baselines(view, SHORTEST, LONGEST)
    np.testing.assert_array_equal(np.sort(baselines.lune_counts), baselines.lune_counts)
    for count in np.unique(baselines.lune_counts):
        lengths = baselines.lengths[baselines.lune_counts == count]
        assert np.all(np.diff(lengths) < LONGEST / 8)


@pytest.mark.parametrize('dots', [1, 2, 5])
def test_few_dots_have_no_baseline(dots):
    points = np.random.default_rng(1).uniform(0.0, 0.09, (dots, 2))
    assert len(list_baselines(view_dots(points, 4000.0), SHORTEST, LONGEST).ends) == 0
