"""Pole-star signatures: properties of the distances and of the vote."""

import numpy as np
import pytest
from numpy.typing import NDArray

from floor_localizer.core.pole_star.signature import (
    build_signature_table,
    pearson_residuals,
    pole_star_signature,
    top_candidates,
    vote,
)
from shirube_core.geometry import SE2

RADIUS, QUANTUM, TOLERANCE = 0.09, 0.0005, 0.00075
FLOOR = np.random.default_rng(1).uniform(0.0, 0.5, (1350, 2))
TABLE = build_signature_table(FLOOR, RADIUS, QUANTUM)


def view_of(centre: tuple[float, float], half_width: float) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    inside = np.flatnonzero(np.abs(FLOOR - centre).max(axis=1) < half_width)
    return SE2(*centre, 0.7).inverse().transform(FLOOR[inside]), inside


def test_the_signature_is_the_sorted_distances_within_the_radius():
    points = np.array([[0.0, 0.0], [0.04, 0.03], [0.0, -0.02], [0.06, 0.08]])
    np.testing.assert_allclose(pole_star_signature(points, 0, RADIUS), [0.02, 0.05])


def test_no_motion_of_the_camera_changes_the_signature():
    moved = pole_star_signature(SE2(3.0, -2.0, 1.1).transform(FLOOR), 17, RADIUS)
    np.testing.assert_allclose(moved, pole_star_signature(FLOOR, 17, RADIUS), atol=1e-12)


@pytest.mark.parametrize('dot', [0, 100, 1349])
def test_the_table_holds_the_histogram_of_each_dots_signature(dot):
    edges = np.arange(len(TABLE.counts) + 1) * QUANTUM
    histogram, _ = np.histogram(pole_star_signature(FLOOR, dot, RADIUS), edges)
    np.testing.assert_array_equal(TABLE.counts[:, dot], histogram)


def test_each_distance_has_one_vote():
    view, _ = view_of((0.25, 0.25), 0.045)
    distances = [len(pole_star_signature(view, pole, RADIUS)) for pole in range(len(view))]
    np.testing.assert_allclose(vote(TABLE, view, TOLERANCE).sum(axis=1), distances, rtol=1e-4)


def test_a_lone_distance_votes_for_the_dots_that_have_it():
    floor = np.array([[0.0, 0.0], [0.02, 0.0], [1.0, 0.0], [1.0, 0.03]])
    table = build_signature_table(floor, RADIUS, QUANTUM)
    votes = vote(table, np.array([[0.0, 0.0], [0.0, 0.0203]]), TOLERANCE)
    np.testing.assert_allclose(votes, [[0.5, 0.5, 0.0, 0.0]] * 2)


def test_the_dots_in_view_are_the_top_candidates():
    view, inside = view_of((0.25, 0.25), 0.045)
    candidates = top_candidates(pearson_residuals(vote(TABLE, view, TOLERANCE)), 5)
    found = [dot in row for dot, row in zip(inside, candidates)]
    assert np.mean(found) > 0.9


def test_pearson_residuals_are_what_the_margins_do_not_explain():
    votes = np.random.default_rng(2).uniform(0.1, 1.0, (6, 9)).astype(np.float32)
    average = votes.sum(axis=1, keepdims=True) * votes.sum(axis=0) / votes.sum()
    above = pearson_residuals(votes) * np.sqrt(average)
    np.testing.assert_allclose(above.sum(axis=0), 0.0, atol=1e-5)
    np.testing.assert_allclose(above.sum(axis=1), 0.0, atol=1e-5)
    # Votes that differ only by crowding leave no residual.
    votes = np.outer([1.0, 2.0, 3.0], [5.0, 1.0, 0.0, 2.0]).astype(np.float32)
    np.testing.assert_allclose(pearson_residuals(votes), 0.0, atol=1e-5)


def test_the_top_candidates_have_the_most_votes():
    votes = np.random.default_rng(3).permuted(np.tile(np.arange(20.0, dtype=np.float32), (4, 1)), axis=1)
    chosen = np.take_along_axis(votes, top_candidates(votes, 3), axis=1)
    np.testing.assert_array_equal(np.sort(chosen, axis=1), [[17.0, 18.0, 19.0]] * 4)
    np.testing.assert_array_equal(np.sort(top_candidates(votes, 50), axis=1), [np.arange(20)] * 4)
