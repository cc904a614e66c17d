"""Lunes and quadruples compared to brute force."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from floor_localizer.core.constellation.baselines import (
    MAX_QUADRUPLES,
    distance,
    dots_in_lune,
    list_quadruples,
)


def gaps(points):
    return np.linalg.norm(points[:, None] - points, axis=2)


def test_distance_is_that_of_the_plane():
    points = np.random.default_rng(0).normal(size=(5, 2))
    for i, j in itertools.product(range(5), repeat=2):
        assert distance(points, i, j) == pytest.approx(gaps(points)[i, j])


@pytest.mark.parametrize('seed', range(6))
def test_lune_holds_the_dots_near_to_both_ends(seed):
    points = np.random.default_rng(seed).uniform(0.0, 1.0, (20, 2))
    lune = np.empty(20, dtype=np.int64)
    longest = distance(points, 0, 1)
    near = gaps(points)
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
