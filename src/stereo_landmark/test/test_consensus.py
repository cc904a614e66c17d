from dataclasses import replace

import numpy as np
from place_scenes import RIG, panel, random_state, teach, view

from stereo_landmark.core.place.place_locator import NoPlaceFix, NoPlaceFixReason, PlaceLocator
from stereo_landmark.core.place.point_registration import consistent_points, find_consensus_set

NOISE = 0.1
NEXT_ROW = np.array([0.0, 0.0, 0.03])
"""Spacing of the repetitive pattern [m]."""


def mismatched_points(count, seed, step=NEXT_ROW):
    """Return measured points, taught points and the state; some points are mismatched to the next row."""
    rng = np.random.default_rng(seed)
    points, state = panel(depth=0.3, seed=seed), random_state(rng)
    wrong = rng.choice(len(points), count, replace=False)
    moved = points.copy()
    moved[wrong] += step
    return view(moved, state, NOISE, rng), teach(points, NOISE, rng), state, wrong


def test_all_points_of_one_displacement_agree():
    for seed in range(20):
        seen, taught, _, _ = mismatched_points(0, seed)
        found = PlaceLocator(RIG).spatial_points(seen)
        assert find_consensus_set(found, taught, 0.0).inliers.all()


def test_a_family_that_was_taken_for_its_neighbours_is_outvoted():
    for seed in range(20):
        seen, taught, _, wrong = mismatched_points(5, seed, 4.0 * NEXT_ROW)
        found = PlaceLocator(RIG).spatial_points(seen)
        inliers = find_consensus_set(found, taught, 0.0).inliers
        assert not inliers[wrong].any()
        assert inliers.sum() == 11


def test_a_near_family_is_seen_by_the_vote_but_not_by_the_distances():
    """Distances between two adjacent groups change little."""
    voted = by_distance = 0
    for seed in range(20):
        seen, taught, _, wrong = mismatched_points(5, seed)
        found = PlaceLocator(RIG).spatial_points(seen)
        voted += int(find_consensus_set(found, taught, 0.0).inliers[wrong].sum())
        by_distance += int(consistent_points(found, taught)[wrong].sum())
    assert voted < 0.5 * by_distance


def test_the_fix_is_right_where_a_third_of_the_points_is_mistaken():
    for seed in range(20):
        seen, taught, state, _ = mismatched_points(5, seed, 4.0 * NEXT_ROW)
        fix = PlaceLocator(RIG).locate(seen, taught)
        error = np.array([fix.T_place_base.x, fix.T_place_base.y, fix.height]) - state[:3]
        assert np.linalg.norm(error) < 0.03
        assert len(fix.names) >= 10


def test_two_groups_with_equal_support_are_ambiguous():
    for seed in range(10):
        seen, taught, _, _ = mismatched_points(8, seed, 4.0 * NEXT_ROW)
        fix = PlaceLocator(RIG).locate(seen, taught)
        assert isinstance(fix, NoPlaceFix)
        assert fix.reason is NoPlaceFixReason.INCONSISTENT


def test_points_on_one_vertical_line_determine_no_yaw():
    points = np.array([[3.0, 0.1, 0.2 * i] for i in range(4)])
    seen = view(points, np.zeros(6))
    found = PlaceLocator(RIG).spatial_points(seen)
    vote = find_consensus_set(found, teach(points), 0.0)
    assert not vote.inliers.any()
    assert vote.support == 0.0


def test_what_both_images_show_in_different_rows_is_left_out():
    points = panel()
    seen = view(points, np.zeros(6), NOISE, np.random.default_rng(1))
    pixels = seen.pixels.copy()
    pixels[:2, 3] += 3.0
    fix = PlaceLocator(RIG).locate(replace(seen, pixels=pixels), teach(points))
    assert {'point 0', 'point 1'}.isdisjoint(fix.names)
    assert len(fix.names) == 14
    pixels[:, 3] = seen.pixels[:, 3] + 3.0
    answer = PlaceLocator(RIG).locate(replace(seen, pixels=pixels), teach(points))
    assert answer.detail.startswith('0 of 16 points are in the same row of both images; ')


def measured(points, state, seed, noise=0.1):
    rng = np.random.default_rng(seed)
    return PlaceLocator(RIG).spatial_points(view(points, state, noise, rng)), teach(panel(), noise, rng)


def test_points_that_only_moved_together_are_consistent():
    for seed in range(20):
        found, taught = measured(panel(), random_state(np.random.default_rng(seed)), seed)
        assert consistent_points(found, taught).all()


def test_points_elsewhere_are_left_out_and_only_they():
    for seed in range(20):
        points = panel()
        wrong = np.random.default_rng(seed).choice(16, 5, replace=False)
        points[wrong] += np.random.default_rng(seed).choice([-1.0, 1.0], (5, 3)) * [0.3, 0.15, 0.12]
        found, taught = measured(points, random_state(np.random.default_rng(seed)), seed)
        kept = consistent_points(found, taught)
        assert not kept[wrong].any()
        assert kept.sum() == 11


def test_two_inconsistent_points_are_both_rejected():
    points = panel(count=2)
    found, taught = measured(points + np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.0]]), np.zeros(6), 1)
    assert not consistent_points(found, taught.select(found.names)).any()
