"""The index finds the place of a view, keeps an ambiguous runner-up, and stops at its budget."""

import numpy as np
import pytest
from search_scenes import new_search_for, scene, similarity

from floor_localizer.core.constellation.acceptance import is_accepted, new_search, score_hypothesis
from floor_localizer.core.constellation.constellation_search import (
    rounds_for_index,
    run_search_rounds,
    search_constellations,
)
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap

CELLS = 400000


def distance(found, pose):
    return found.pose.distance_to(pose)


@pytest.mark.parametrize('seed', range(6))
@pytest.mark.parametrize('key_count', [None, 10**9])
def test_place_of_a_view_is_found_also_by_the_rounds_for_very_many_keys(floor, indexed_floor, key_count, seed):
    pose, _, dots = scene(floor, indexed_floor, seed, missing=0.2, spurious=8)
    search, (grid, index) = new_search_for(dots, indexed_floor), (indexed_floor.grid, indexed_floor.index)
    if key_count is None:
        assert search_constellations(grid, index, dots, search, CELLS)
    else:
        assert run_search_rounds(grid, index, dots, search, rounds_for_index(key_count), CELLS)
    assert is_accepted(search, search.best)
    assert not is_accepted(search, search.runner_up)
    assert distance(search.best, pose) < 0.001


def test_no_key_is_left_out_or_tried_twice():
    rng = np.random.default_rng(1)
    probability, misfit = 10.0 ** rng.uniform(-4.0, 0.0, 3000), rng.uniform(0.0, 20.0, 3000)
    tried = []
    for keys in (10**6, 10**9):
        minimum, maximum, closest, farthest = rounds_for_index(keys).T[:, :, None]
        is_likely = (probability >= minimum) & (probability < maximum)
        tried.append((is_likely & (misfit >= closest) & (misfit < farthest)).sum(axis=0))
        assert tried[-1].max() == 1
    np.testing.assert_array_equal(*tried)
    np.testing.assert_array_equal(tried[0], (probability >= 0.0008) & (misfit < 17.5))


def test_without_budget_little_is_looked_up(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 0, missing=1.0, spurious=200)
    few, many = new_search_for(dots, indexed_floor), new_search_for(dots, indexed_floor)
    assert not search_constellations(indexed_floor.grid, indexed_floor.index, dots, few, 0)
    assert not search_constellations(indexed_floor.grid, indexed_floor.index, dots, many, CELLS)
    assert few.counts[0] < many.counts[0]


def test_truth_is_accepted_but_not_chance_another_scale_or_the_same_place_twice(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    a, b = similarity(pose)
    search = new_search_for(dots, indexed_floor)
    assert not score_hypothesis(indexed_floor.grid, dots, search, a, b + 0.05)
    assert score_hypothesis(indexed_floor.grid, dots, search, a, b)
    assert distance(search.best, pose) < 0.001

    for shift in (1e-4, 0.0, -1e-4):
        score_hypothesis(indexed_floor.grid, dots, search, a, b + shift)
    assert is_accepted(search, search.best)
    assert not is_accepted(search, search.runner_up)
    larger = dots._replace(points=dots.points * 1.2, z=dots.z * 1.2)
    assert not score_hypothesis(indexed_floor.grid, larger, new_search_for(larger, indexed_floor), a / 1.2, b)


def test_too_few_matches_are_not_accepted_however_unlikely():
    search = new_search(100, 1e5, 1e-3, 0.25)
    assert not is_accepted(search, search.best)
    search.poses[0] = -1000.0, 1.0, 0.0, 24.0
    assert not is_accepted(search, search.best)
    search.poses[0]['matched'] = 25.0
    assert is_accepted(search, search.best)


def test_a_view_of_two_places_finds_both(floor):
    shift = np.array([2.0, 0.0])
    points = np.vstack([floor.points, floor.points + shift])
    twice = index_map(DotMap(points, np.full(len(points), np.nan)))
    pose, _, dots = scene(floor, twice, 3, missing=0.2, spurious=8)
    search = new_search_for(dots, twice)
    assert search_constellations(twice.grid, twice.index, dots, search, CELLS)
    found = sorted((place.pose for place in (search.best, search.runner_up)), key=lambda place: place.x)
    assert is_accepted(search, search.runner_up)
    assert found[0].distance_to(pose) < 0.001
    assert found[1].x - found[0].x == pytest.approx(shift[0], abs=0.001)


def test_the_same_view_is_searched_in_the_same_way(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 4, missing=0.3, spurious=20)
    first, second = new_search_for(dots, indexed_floor), new_search_for(dots, indexed_floor)
    for search in (first, second):
        search_constellations(indexed_floor.grid, indexed_floor.index, dots, search, CELLS)
    np.testing.assert_array_equal(first.counts, second.counts)
    assert first.best == second.best
