"""The index finds the place of a view, keeps the place that looks alike, and stops at its budget."""

from __future__ import annotations

import numpy as np
import pytest
from search_scenes import SIGMA, found_pose, scene, search_of, similarity

from floor_localizer.core.constellation.constellation_search import key_tolerance, search_constellations
from floor_localizer.core.constellation.search_state import is_accepted, judge, new_search

CELLS = 400000


def distance(found, pose):
    return found_pose(found).distance_to(pose)


@pytest.mark.parametrize('seed', range(6))
def test_place_of_a_view_is_found(floor, indexed_floor, seed):
    pose, _, dots = scene(floor, indexed_floor, seed, missing=0.2, spurious=8)
    search = search_of(dots, indexed_floor)
    assert search_constellations(indexed_floor.grid, indexed_floor.index, dots, search, CELLS)
    assert is_accepted(search, search.best)
    assert not is_accepted(search, search.rival)
    assert distance(search.best, pose) < 0.001


def test_without_budget_little_is_looked_up(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 0, missing=1.0, spurious=200)
    few, many = search_of(dots, indexed_floor), search_of(dots, indexed_floor)
    assert not search_constellations(indexed_floor.grid, indexed_floor.index, dots, few, 0)
    assert not search_constellations(indexed_floor.grid, indexed_floor.index, dots, many, CELLS)
    assert few.counts[0] < many.counts[0]


def test_truth_is_judged_right_and_chance_is_not(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    a, b = similarity(pose)
    search = search_of(dots, indexed_floor)
    assert not judge(indexed_floor.grid, dots, search, a, b + 0.05)
    assert judge(indexed_floor.grid, dots, search, a, b)
    assert distance(search.best, pose) < 0.001


def test_the_same_place_twice_is_no_rival(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    a, b = similarity(pose)
    search = search_of(dots, indexed_floor)
    for shift in (1e-4, 0.0, -1e-4):
        judge(indexed_floor.grid, dots, search, a, b + shift)
    assert is_accepted(search, search.best)
    assert not is_accepted(search, search.rival)


def test_a_guess_of_another_scale_is_refused(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 2)
    larger = dots._replace(points=dots.points * 1.2, z=dots.z * 1.2)
    a, b = similarity(pose)
    assert not judge(indexed_floor.grid, larger, search_of(larger, indexed_floor), a / 1.2, b)


def test_a_new_search_has_accepted_nothing():
    search = new_search(20, 1e5, 1e-3, 0.25)
    assert not is_accepted(search, search.best)
    assert search.least_matches == 5.0


def test_too_few_matches_are_not_accepted_however_unlikely():
    search = new_search(100, 1e5, 1e-3, 0.25)
    search.best[:] = -1000.0, 1.0, 0.0, 0.0, 0.0, 24.0
    assert not is_accepted(search, search.best)
    search.best[5] = 25.0
    assert is_accepted(search, search.best)


def test_tolerance_and_length_change_places():
    length = key_tolerance(SIGMA, 0.1)
    assert key_tolerance(SIGMA, length) == pytest.approx(0.1)


def test_tolerance_keeps_nine_of_ten_true_coordinates():
    rng = np.random.default_rng(0)
    length, base = 0.03, np.array([[0.0, 0.0], [0.03, 0.0]])
    dots = rng.uniform((0.005, -0.015), (0.025, 0.015), (2000, 2))

    def x_of(ends, dot):
        arm = ends[1] - ends[0]
        return (dot - ends[0]) @ arm / (arm @ arm)

    off = [
        x_of(base + rng.normal(0, SIGMA, (2, 2)), dot + rng.normal(0, SIGMA, 2)) - x_of(base, dot)
        for dot in dots
    ]
    assert np.mean(np.abs(off) <= key_tolerance(SIGMA, length)) > 0.95
