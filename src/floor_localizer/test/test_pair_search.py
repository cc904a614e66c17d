"""Pairs matched to the whole map find sparse views; the choice of pairs covers the view."""

from __future__ import annotations

import numpy as np
import pytest
from search_scenes import new_search_for, scene

from floor_localizer.core.constellation.acceptance import is_accepted
from floor_localizer.core.constellation.pair_search import choose_pairs, search_pairs


@pytest.mark.parametrize('seed', range(4))
def test_sparse_views_are_found(floor, indexed_floor, seed):
    pose, _, dots = scene(floor, indexed_floor, seed, missing=0.6, spurious=3)
    search = new_search_for(dots, indexed_floor)
    assert search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 24)
    assert not is_accepted(search, search.runner_up)
    assert search.best.pose.distance_to(pose) < 0.001


def test_a_view_of_nothing_is_not_found(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 0, missing=1.0, spurious=40)
    search = new_search_for(dots, indexed_floor)
    assert not search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 6)
    assert search.counts[1] > 0


def test_chosen_pairs_are_all_of_the_length_and_each_once(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 1)
    pairs = choose_pairs(dots, 0.015, 0.03)
    lengths = np.abs(dots.z[pairs[:, 0]] - dots.z[pairs[:, 1]])
    assert np.all((lengths >= 0.015) & (lengths <= 0.03))
    assert len({frozenset(pair) for pair in pairs.tolist()}) == len(pairs)
    gaps = np.abs(dots.z[:, None] - dots.z)
    assert len(pairs) == np.sum(np.triu((gaps >= 0.015) & (gaps <= 0.03)))


def test_first_pairs_have_no_dot_in_common(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 1)
    first = choose_pairs(dots, 0.01, 0.04)[:8].ravel()
    assert len(set(first.tolist())) == len(first)


def test_no_pairs_no_pose(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 1)
    search = new_search_for(dots, indexed_floor)
    assert not search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 0)
