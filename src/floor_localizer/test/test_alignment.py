"""Similarities compared to numpy's least squares; hypotheses are accepted if and only if they are right."""

import cmath

import numpy as np
import pytest
from scipy.spatial import cKDTree
from search_scenes import SIGMA, scene, similarity

from floor_localizer.core.constellation.alignment import (
    add_match,
    empty_sums,
    fit_similarity,
    match_view,
    verify_hypothesis,
)


def fit(z, m):
    sums = empty_sums()
    for view_dot, map_dot in zip(z, m, strict=True):
        sums = add_match(sums, complex(view_dot), complex(map_dot))
    return fit_similarity(sums)


def test_similarity_of_exact_dots_is_exact():
    z = np.random.default_rng(1).normal(size=(7, 2)) @ (1.0, 1j)
    a, b = 1.3 * cmath.exp(2.2j), 4.0 - 7.0j
    found = fit(z, a * z + b)
    assert found[0] == pytest.approx(a)
    assert found[1] == pytest.approx(b)
    assert found[2] == pytest.approx(np.sum(np.abs(z - z.mean()) ** 2))


def test_similarity_of_noisy_dots_is_that_of_least_squares():
    rng = np.random.default_rng(2)
    z, m = rng.normal(size=(7, 2)) @ (1.0, 1j), rng.normal(size=(7, 2)) @ (1.0, 1j)
    expected, *_ = np.linalg.lstsq(np.column_stack([z, np.ones(7)]), m, rcond=None)
    np.testing.assert_allclose(fit(z, m)[:2], expected, atol=1e-12)


def map_dots(floor, indexed, view):
    """The index of each view dot's map dot in the grid, -1 for a spurious one."""
    _, nearest = cKDTree(indexed.grid.points).query(floor.points[view.sources])
    return np.where(view.sources >= 0, nearest, -1)


def pairs_of(truth, dots, number):
    """Pairs of true view dots a few spacings apart."""
    real = np.flatnonzero(truth >= 0)
    near = [(i, j) for i in real for j in real if i < j and 0.015 < abs(dots.z[i] - dots.z[j]) < 0.04]
    return near[:: max(len(near) // number, 1)]


def test_right_hypotheses_are_verified_with_the_right_similarity(floor, indexed_floor):
    pose, view, dots = scene(floor, indexed_floor, 3)
    truth, middle = map_dots(floor, indexed_floor, view), np.mean(dots.z)
    a, b = similarity(pose)
    results = []
    for i, j in pairs_of(truth, dots, 40):
        pair = np.array([i, j])
        good, found_a, found_b = verify_hypothesis(indexed_floor.grid, dots, pair, truth[i], truth[j])
        if good:
            assert abs(found_a * middle + found_b - (a * middle + b)) < 0.01
        results.append(good)
    assert np.mean(results) > 0.9


def test_wrong_hypotheses_are_rejected(floor, indexed_floor):
    _, view, dots = scene(floor, indexed_floor, 3)
    truth = map_dots(floor, indexed_floor, view)
    tree = cKDTree(indexed_floor.grid.points)
    rng = np.random.default_rng(0)
    accepted = []
    for i, j in pairs_of(truth, dots, 40):
        start = int(rng.integers(len(indexed_floor.grid.points)))
        length = abs(dots.z[i] - dots.z[j])
        for end in tree.query_ball_point(indexed_floor.grid.points[start], 1.04 * length):
            apart = np.linalg.norm(indexed_floor.grid.points[start] - indexed_floor.grid.points[end])
            if apart > 0.96 * length and start != truth[i]:
                accepted.append(verify_hypothesis(indexed_floor.grid, dots, np.array([i, j]), start, end)[0])
    assert len(accepted) > 50
    assert np.mean(accepted) < 0.02


def test_a_hypothesis_of_another_scale_is_rejected_at_once(floor, indexed_floor):
    _, view, dots = scene(floor, indexed_floor, 3)
    truth = map_dots(floor, indexed_floor, view)
    i, j = pairs_of(truth, dots, 10)[0]
    larger = dots._replace(points=dots.points * 1.3, z=dots.z * 1.3)
    assert not verify_hypothesis(indexed_floor.grid, larger, np.array([i, j]), truth[i], truth[j])[0]


def test_the_other_seeds_must_be_on_the_map(floor, indexed_floor):
    _, view, dots = scene(floor, indexed_floor, 4, spurious=3)
    truth = map_dots(floor, indexed_floor, view)
    false = np.flatnonzero(view.sources < 0)[0]
    lost = [
        verify_hypothesis(indexed_floor.grid, dots, np.array([i, j, false]), truth[i], truth[j])[0]
        for i, j in pairs_of(truth, dots, 20)
    ]
    assert np.mean(lost) < 0.3


def test_matched_views_are_those_of_the_truth(floor, indexed_floor):
    pose, view, dots = scene(floor, indexed_floor, 5, spurious=4)
    matches, residuals = np.empty(len(dots.z), dtype=np.int64), np.empty(len(dots.z))
    a, b = similarity(pose)
    matched, found_a, found_b = match_view(indexed_floor.grid, dots, a, b + 1e-4, matches, residuals)
    truth = map_dots(floor, indexed_floor, view)
    assert matched == np.sum(matches >= 0)
    assert np.all(np.isfinite(residuals) == (matches >= 0))
    assert np.mean(matches[truth >= 0] == truth[truth >= 0]) > 0.95
    assert abs(found_a - a) < 0.01
    assert abs(found_b - b) < 10 * SIGMA


def test_nothing_is_matched_far_from_the_map(floor, indexed_floor):
    _, _, dots = scene(floor, indexed_floor, 5)
    matches, residuals = np.empty(len(dots.z), dtype=np.int64), np.empty(len(dots.z))
    matched, _, _ = match_view(indexed_floor.grid, dots, 1.0 + 0.0j, 50.0 + 0.0j, matches, residuals)
    assert matched == 0
    assert np.all(np.isinf(residuals))
