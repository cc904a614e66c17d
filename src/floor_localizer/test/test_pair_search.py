"""Pairs matched to the whole map find sparse views; the choice of pairs covers the view."""

import math

import numpy as np
import pytest
from search_scenes import new_search_for, scene, view_dots

from floor_localizer.core.constellation.acceptance import is_accepted
from floor_localizer.core.constellation.pair_search import choose_pairs, search_near, search_pairs
from shirube_core.geometry import SE2


@pytest.mark.parametrize('seed', range(4))
def test_sparse_views_are_found(floor, indexed_floor, seed):
    pose, _, dots = scene(floor, indexed_floor, seed, missing=0.6, spurious=3)
    search = new_search_for(dots, indexed_floor)
    assert search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 24)
    assert not is_accepted(search, search.runner_up)
    assert search.best.pose.distance_to(pose) < 0.001


@pytest.mark.parametrize('seed', range(3))
def test_a_view_whose_dots_are_all_far_apart_is_found(floor, indexed_floor, seed):
    pose, _, dots = scene(floor, indexed_floor, seed, noise=0.05)
    kept = list[int]()
    for k, z in enumerate(dots.z):
        if np.all(np.abs(z - dots.z[kept]) > 2.0 * indexed_floor.grid.cell):
            kept.append(k)
    few = view_dots(dots.points[kept], indexed_floor.density)
    assert len(choose_pairs(few, 0.0, 2.0 * indexed_floor.grid.cell)) == 0
    search = new_search_for(few, indexed_floor)
    assert search_pairs(indexed_floor.grid, indexed_floor.addresses, few, search, 24)
    assert search.best.pose.distance_to(pose) < 0.001


def test_a_view_of_nothing_is_not_found_nor_one_without_pairs(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 0, missing=1.0, spurious=40)
    search = new_search_for(dots, indexed_floor)
    assert not search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 6)
    assert search.counts[1] > 0
    _, _, dots = scene(floor, indexed_floor, 1)
    search = new_search_for(dots, indexed_floor)
    assert not search_pairs(indexed_floor.grid, indexed_floor.addresses, dots, search, 0)


def test_chosen_pairs_are_all_of_the_length_and_each_once_the_first_without_common_dots(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 1)
    pairs = choose_pairs(dots, 0.015, 0.03)
    lengths = np.abs(dots.z[pairs[:, 0]] - dots.z[pairs[:, 1]])
    assert np.all((lengths >= 0.015) & (lengths <= 0.03))
    assert len({frozenset(pair) for pair in pairs.tolist()}) == len(pairs)
    gaps = np.abs(dots.z[:, None] - dots.z)
    assert len(pairs) == np.sum(np.triu((gaps >= 0.015) & (gaps <= 0.03)))
    first = choose_pairs(dots, 0.01, 0.04)[:8].ravel()
    assert len(set(first.tolist())) == len(first)


def near(indexed, dots, expected, radius, turn, pairs=12):
    search = new_search_for(dots, indexed)
    place = np.array([expected.x, expected.y, expected.yaw])
    return search_near(indexed.grid, dots, search, place, radius, turn, pairs), search


@pytest.mark.parametrize('radius', [0.003, 0.03])
@pytest.mark.parametrize('turn', [0.02, 0.4, 2.0, math.pi])
def test_a_pose_within_reach_is_found(floor, indexed_floor, radius, turn):
    rng = np.random.default_rng(0)
    for seed in range(4):
        pose, _, dots = scene(floor, indexed_floor, seed, missing=0.3, spurious=8)
        angle = rng.uniform(-math.pi, math.pi)
        shift = 0.9 * radius * np.array([math.cos(angle), math.sin(angle)])
        expected = SE2(pose.x + shift[0], pose.y + shift[1], pose.yaw + rng.uniform(-0.9, 0.9) * turn)
        found, search = near(indexed_floor, dots, expected, radius, turn)
        assert found
        assert search.best.pose.distance_to(pose) < 0.001


@pytest.mark.parametrize(('motion', 'pairs'), [((0.05, 0.0), 12), ((0.0, 0.5), 12), ((0.0, 0.0), 0)])
def test_a_pose_far_off_another_heading_or_any_without_pairs_is_not_found(floor, indexed_floor, motion, pairs):
    pose, _, dots = scene(floor, indexed_floor, 1)
    expected = SE2(pose.x, pose.y + motion[0], pose.yaw + motion[1])
    assert not near(indexed_floor, dots, expected, 0.01, 0.1, pairs)[0]
